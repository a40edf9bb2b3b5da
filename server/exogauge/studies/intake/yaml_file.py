"""YAML from strangers: capped, free of alias bombs, and every fault placed at its line."""

from __future__ import annotations

import difflib
import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar, final

import yaml
from pydantic import BaseModel, ValidationError

from exogauge.errors import BadInput, BadStudy, Fault, TooLarge
from exogauge.logs.channels import shorten

try:
    from yaml import CSafeLoader as _SafeLoader
except ImportError:  # PyYAML built without libyaml: the same, ten times slower
    from yaml import SafeLoader as _SafeLoader  # type: ignore[assignment]

MAX_BYTES = 1_000_000
MAX_DEPTH = 40
MAX_NODES = 50_000  # as written, and again after every alias is written out
MAX_FAULTS = 20

AS_WRITTEN = re.compile(r"[-+]?(0[0-9_]+|.*:.*)$")

Model = TypeVar("Model", bound=BaseModel)
Pointer = tuple[str | int, ...]


@final
@dataclass(frozen=True)
class YamlPage:
    """The written file: says at which line a fault is."""

    file: str
    data: bytes

    def fault(self, detail: str, rule: str, pointer: Pointer, advice: str = "", value: object = None) -> Fault:
        shown = None if value is None else shorten(str(value))
        return Fault(detail, rule, advice, self.file, place(self.data, pointer), dotted(pointer) or None, shown)


class _Loader(_SafeLoader):
    """A safe loader that reads `1e-5` as a number (YAML 1.2), not as text (YAML 1.1)."""


_Loader.yaml_implicit_resolvers = {key: list(value) for key, value in yaml.SafeLoader.yaml_implicit_resolvers.items()}
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def _whole_number(loader: _Loader, node: yaml.ScalarNode) -> int | str:
    """Text where YAML 1.1 would count in eights or sixties: `0042` is a serial number and `1:30` a time."""
    if AS_WRITTEN.match(node.value):
        return str(node.value)
    if len(node.value) > 200:  # more would not fit a float
        raise yaml.constructor.ConstructorError(None, None, "a number with too many digits", node.start_mark)
    return int(loader.construct_yaml_int(node))


_Loader.add_constructor("tag:yaml.org,2002:int", _whole_number)


def load_yaml(data: bytes, model: type[Model], *, file: str, error: type[BadInput] = BadStudy) -> Model:
    """The checked content of one YAML file, or `error` with a `Fault` per broken rule (row = line in the file)."""
    checked, _, faults = read_yaml(data, model, file=file, error=error)
    if checked is None:
        raise error(faults)
    return checked


def read_yaml(
    data: bytes, model: type[Model], *, file: str, error: type[BadInput] = BadStudy
) -> tuple[Model | None, dict[Any, Any], list[Fault]]:
    """(checked content or None, content as written, faults), for callers that look on where the model is broken.

    What is no YAML, or holds no keys and values, raises `error` all the same.
    """
    node = _compose(data, file, error)
    _refuse_duplicate_keys(node, file, error)
    try:
        content = _construct(node)
    except (yaml.YAMLError, ValueError, ArithmeticError, AttributeError, TypeError, LookupError) as problem:
        raise error(_yaml_fault(problem, file)) from None  # PyYAML trips over some explicit tags
    if not isinstance(content, dict):
        raise error(Fault("the file must hold keys and values at its top level", "not_a_mapping", "", file, 1))
    try:
        return model.model_validate(content), content, []
    except ValidationError as invalid:
        return None, content, _faults(invalid.errors(include_url=False)[:MAX_FAULTS], model, node, file)


@lru_cache(maxsize=8)
def _nodes(data: bytes) -> yaml.Node | None:
    return yaml.compose(data.decode("utf-8-sig"), Loader=_Loader)


def place(data: bytes, pointer: Pointer) -> int | None:
    """Line (from 1) of the value that `pointer` leads to, as deep as it can be followed; data: accepted before."""
    node = _nodes(data)
    return None if node is None else _line(node, pointer)


def dotted(pointer: Sequence[str | int]) -> str:
    """`joints.2.prior.k_T`"""
    return ".".join(str(part) for part in pointer)


def suggestion(word: str, known: Sequence[str]) -> str:
    """ "Did you mean …?" where something is near, otherwise the choices."""
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.6)
    if near:
        return f"Did you mean {near[0]!r}?"
    return listed(known)


def listed(known: Sequence[str]) -> str:
    """The choices, the first of them where there are many."""
    shown = ", ".join(list(known)[:12]) + (", …" if len(known) > 12 else "")
    return f"Known here: {shown}." if known else ""


def _compose(data: bytes, file: str, error: type[BadInput]) -> yaml.Node:
    if len(data) > MAX_BYTES:
        fault = Fault(f"the file has {len(data)} bytes, at most {MAX_BYTES} are read", "yaml_too_large", "", file)
        raise TooLarge(fault)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = data[: problem.start].count(b"\n") + 1
        raise error(Fault("the file is not UTF-8 text", "not_utf8", "Save it as UTF-8.", file, line)) from None
    if text.lstrip().startswith("<"):
        advice = "A study.yaml names a robot.yaml, which names the URDF. `exogauge robot` drafts one, for motions " \
                 "`exogauge motion robot`."  # fmt: skip
        raise error(Fault("this is a URDF, or other XML, and no YAML", "a_urdf", advice, file, 1))
    try:
        depth, nodes = 0, 0
        for event in yaml.parse(text, Loader=_Loader):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > MAX_DEPTH:
                row = event.start_mark.line + 1 if event.start_mark else None
                raise TooLarge(Fault(f"nested deeper than {MAX_DEPTH} levels", "yaml_too_deep", "", file, row))
            nodes += isinstance(event, yaml.NodeEvent)
            if nodes > MAX_NODES:
                raise TooLarge(Fault(f"more than {MAX_NODES} values", "yaml_too_large", "", file))
        node = yaml.compose(text, Loader=_Loader)
    except yaml.YAMLError as problem:
        raise error(_yaml_fault(problem, file)) from None
    if node is None:
        raise error(Fault("the file is empty", "empty_file", "", file))
    if _expanded_size(node, {}, set()) > MAX_NODES:
        raise TooLarge(Fault(f"more than {MAX_NODES} values once aliases are written out", "yaml_too_large", "", file))
    return node


def _construct(node: yaml.Node) -> Any:
    loader = _Loader("")
    try:
        return loader.construct_document(node)
    finally:
        loader.dispose()


def _expanded_size(node: yaml.Node, known: dict[int, int], open_nodes: set[int]) -> int:
    """Number of values when every alias is written out; a node inside itself counts as infinite."""
    if isinstance(node, yaml.ScalarNode):
        return 1
    key = id(node)
    if key in open_nodes:
        return MAX_NODES + 1
    if key not in known:
        open_nodes.add(key)
        children = [child for pair in node.value for child in (pair if isinstance(pair, tuple) else (pair,))]
        known[key] = 1 + sum(_expanded_size(child, known, open_nodes) for child in children)
        open_nodes.discard(key)
    return known[key]


def _refuse_duplicate_keys(node: yaml.Node, file: str, error: type[BadInput]) -> None:
    stack, visited = [node], set[int]()
    while stack:
        current = stack.pop()
        if id(current) in visited or isinstance(current, yaml.ScalarNode):
            continue
        visited.add(id(current))
        if isinstance(current, yaml.SequenceNode):
            stack.extend(current.value)
            continue
        keys = set[Hashable]()
        for key, value in current.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in keys and key.value != "<<":
                    row = key.start_mark.line + 1
                    fault = Fault("the key is written twice", "duplicate_key", "Keep one.", file, row, str(key.value))
                    raise error(fault)
                keys.add(key.value)
            stack.append(value)


def _yaml_fault(problem: Exception, file: str) -> Fault:
    mark = getattr(problem, "problem_mark", None)
    detail = getattr(problem, "problem", None) or str(problem).splitlines()[0]
    row = None if mark is None else mark.line + 1
    return Fault(f"not readable as YAML: {detail}", "not_yaml", "Check indentation, brackets and quotes.", file, row)


def _faults(found: Sequence[Any], model: type[BaseModel], node: yaml.Node, file: str) -> list[Fault]:
    """Of a value that may be of several kinds, what is wrong with it as the kind that it is."""
    faults = [_fault(dict(item), model, node, file) for item in found]
    other = {fault.column for fault in faults if not fault.rule.endswith("_type")}
    kept = [
        fault
        for item, fault in zip(found, faults, strict=True)
        if _as_one_of(item["loc"]) == item["loc"] or not fault.rule.endswith("_type") or fault.column not in other
    ]
    return list({(fault.column, fault.detail): fault for fault in kept}.values())


def _as_one_of(pointer: Pointer) -> Pointer:
    """Without what pydantic calls the kinds that a value may be of: `dict[...]`, which nobody wrote."""
    return tuple(part for part in pointer if "[" not in str(part))


def _fault(item: dict[str, Any], model: type[BaseModel], node: yaml.Node, file: str) -> Fault:
    pointer = _as_one_of(item["loc"])
    advice = ""
    value = item.get("input")
    shown = None if isinstance(value, dict | list) else repr(value)[:80]
    if item["type"] == "extra_forbidden":
        detail = f"unknown key {str(pointer[-1])!r}"
        advice = suggestion(str(pointer[-1]), _fields_at(model, pointer[:-1]))
        shown = None
    elif item["type"] == "missing":
        detail, shown = f"the key {str(pointer[-1])!r} is missing", None
    else:
        detail = str(item["msg"]).removeprefix("Value error, ")
        expected = item.get("ctx", {}).get("expected")
        if expected and isinstance(value, str):
            advice = suggestion(value, re.findall(r"'([^']+)'", str(expected)))
    return Fault(detail, str(item["type"]), advice, file, _line(node, pointer), dotted(pointer) or None, shown)


def _fields_at(model: type[BaseModel], pointer: Pointer) -> list[str]:
    """Names of the keys allowed at a place, found by walking the models' annotations."""
    current: set[type[BaseModel]] = {model}
    for part in pointer:
        if isinstance(part, int):
            continue
        fields = [each.model_fields[part] for each in current if part in each.model_fields]
        current = {found for field in fields for found in _models_in(field.annotation)}
    return sorted({name for each in current for name in each.model_fields})


def _models_in(annotation: Any) -> set[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return {annotation}
    return {found for argument in getattr(annotation, "__args__", ()) for found in _models_in(argument)}


def _line(node: yaml.Node, pointer: Pointer) -> int:
    """Line of the last part of `pointer` that exists: its key in a mapping, its item in a sequence."""
    line = node.start_mark.line
    for part in pointer:
        if isinstance(node, yaml.MappingNode):
            pairs = {key.value: (key, value) for key, value in node.value if isinstance(key, yaml.ScalarNode)}
            if str(part) not in pairs:
                break
            key, node = pairs[str(part)]
            line = key.start_mark.line
        elif isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
            node = node.value[part]
            line = node.start_mark.line
        else:
            break
    return int(line) + 1
