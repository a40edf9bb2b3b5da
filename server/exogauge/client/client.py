"""`exogauge.Client`: upload, submit, wait, read the result."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar, final
from urllib.parse import quote

import httpx

from exogauge.client.problems import ClientProblem, NotNow, problem_of_job
from exogauge.client.things import (
    Artifact,
    Device,
    Job,
    Log,
    Motion,
    Payload,
    Plan,
    Publication,
    Robot,
    Study,
    WhatIf,
    thing,
)
from exogauge.client.tokens import token_for
from exogauge.client.transport import Transport, has
from exogauge.client.uploading import send, send_described, send_logs
from exogauge.terminal import bar

if TYPE_CHECKING:
    from exogauge.client.live import LiveStream

Thing = TypeVar("Thing")

POLL_S = 0.2
RESULTS = "results.json"
STUDY, ROBOT, DEVICE, PAYLOAD = "study.yaml", "robot.yaml", "device.yaml", "payload.yaml"
PATHS: Mapping[type, str] = {
    Study: "studies", Robot: "robots", Device: "devices", Log: "logs", Payload: "payloads", Motion: "motions",
    Plan: "plans",
}  # fmt: skip


@final
class Client:
    """Talks to one service. Raises `ClientProblem` with what the service said; everything may be called again."""

    def __init__(
        self,
        url: str = "http://127.0.0.1:8765",
        *,
        token: str | None = None,
        timeout_s: float = 120.0,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        """token: where the service has accounts; without it that of EXOGAUGE_TOKEN, or of `exogauge login`."""
        self.url = url.rstrip("/")
        self._token = token or token_for(url)
        self._http = Transport(url, timeout_s, transport, self._token)

    def health(self) -> dict[str, Any]:
        """Whether the service can serve, and how many workers live."""
        answer: dict[str, Any] = self._http.get(f"{self.url}/readyz")
        return answer

    def session(self) -> dict[str, Any]:
        """Who the service takes us for: {accounts, account, lab: {id, name, role}, labs}."""
        answer: dict[str, Any] = self._http.get("session")
        return answer

    def upload_study(self, path: str | Path) -> Study:
        """A study's folder, its study.yaml, or a zip. The same files are the same study.

        From 64 MiB on it goes up in pieces and survives broken connections; a bar on stderr shows what has arrived.
        """
        return thing(Study, send_logs(self._http, "studies", Path(path), STUDY))

    def upload_payload(self, path: str | Path) -> Payload:
        """A payload's folder, its payload.yaml, or a zip; large ones as large studies. Other files under the same name
        are its next version."""
        return thing(Payload, send_logs(self._http, "payloads", Path(path), PAYLOAD))

    def upload(self, file: str | Path, *, progress: bool = False) -> str:
        """Send one file of any size in pieces, going on where it was when the line breaks; returns the upload's id."""
        return send(self._http, Path(file), shown=progress)

    def study_of_uploads(self, uploads: Sequence[str], paths: Sequence[str] | None = None) -> Study:
        """A study of files that were uploaded before: one zip, or several files with their paths in the study."""
        body = {"upload_ids": list(uploads)} | ({} if paths is None else {"paths": list(paths)})
        return thing(Study, self._http.post("studies/from-upload", body))

    def upload_robot(self, path: str | Path) -> Robot:
        """A robot.yaml (with the URDF it names), a folder that holds nothing but the robot, or a zip."""
        return thing(Robot, send_described(self._http, "robots", Path(path), ROBOT))

    def upload_device(self, path: str | Path, robot: Robot | str) -> Device:
        """A device.yaml (with the bench tests it names), a folder that holds nothing but the device, or a zip.

        robot: who wears it; its links are what the via points name.
        """
        return thing(Device, send_described(self._http, "devices", Path(path), DEVICE, {"robot": id_of(robot)}))

    def upload_log(self, path: str | Path, mapping: str | Path | None = None, robot: Robot | str | None = None) -> Log:
        """One log. mapping: a mapping.yaml that names its columns; robot: whose gears the mapping needs."""
        parts = {"file": Path(path)} | ({"mapping": Path(mapping)} if mapping is not None else {})
        form = {"robot_id": id_of(robot)} if robot is not None else None
        return thing(Log, self._http.post("logs", files=parts, form=form))

    def create_study(
        self,
        name: str,
        robot: Robot | str,
        logs: list[dict[str, Any]],
        settings: Mapping[str, Any] | None = None,
        device: Device | str | None = None,
        known: list[dict[str, Any]] | None = None,
    ) -> Study:
        """A study of a robot and logs uploaded before, and of what was worn.

        logs: [{"log_id", "role", "motion"?, "rows"?, "name"?, "device_id"?, "started"?}]. device: for logs with role
        with_device that name none. known: weighed loads, as in study.yaml; give the logs that they name a "name".
        """
        body = {"name": name, "robot_id": id_of(robot), "logs": logs, "settings": settings and dict(settings)}
        worn = {} if device is None else {"device_id": id_of(device)}
        carried = {} if known is None else {"known": known}
        return thing(Study, self._http.post("studies", body | worn | carried))

    def delete(self, what: Study | Robot | Device | Log | Payload | Motion | Plan) -> None:
        """With its jobs and results. ClientProblem 409 where something else needs it."""
        self.delete_by_id(next(path for kind, path in PATHS.items() if isinstance(what, kind)), what.id)

    def delete_by_id(self, nouns: str, key: str) -> None:
        """nouns: studies, robots, devices, logs, payloads, motions or plans."""
        self._http.delete(f"{nouns}/{quote(key, safe='')}")

    def studies(self, search: str | None = None) -> Iterator[Study]:
        """All studies, newest first; those whose name holds the words of `search`, where given."""
        return self._all("studies", Study, {} if search is None else {"search": search})

    def robots(self) -> Iterator[Robot]:
        return self._all("robots", Robot)

    def devices(self, name: str | None = None, robot: Robot | str | None = None) -> Iterator[Device]:
        """All devices, newest first; the versions of one name, or those of one robot, where given."""
        asked = {"name": name, "robot_id": None if robot is None else id_of(robot)}
        return self._all("devices", Device, {key: value for key, value in asked.items() if value is not None})

    def payloads(self, name: str | None = None) -> Iterator[Payload]:
        """All payloads, newest first; the versions of one name, where given."""
        return self._all("payloads", Payload, {} if name is None else {"name": name})

    def payload(self, payload: Payload | str) -> Payload:
        return thing(Payload, self._http.get(f"payloads/{id_of(payload)}"))

    def identify_payload(self, payload: Payload | str, settings: Mapping[str, Any] | None = None) -> Job:
        """Ask for mass, centre, inertia, zero and inclination. settings: override those of payload.yaml."""
        body = {"payload_id": id_of(payload), "kind": "payload", "settings": dict(settings or {})}
        return thing(Job, self._http.post("jobs", body))

    def plan_payload(self, payload: Payload | str, what: str) -> Job:
        """Ask what to record. what: postures or excitation."""
        return thing(Job, self._http.post(f"payloads/{id_of(payload)}/plans", {"what": what}))

    def payload_plans(self, payload: Payload | str) -> list[dict[str, Any]]:
        """Newest first: [{job, found: what it will tell, or None, files}]."""
        return list(self._items(f"payloads/{id_of(payload)}/plans"))

    def payload_results(self, payload: Payload | str) -> dict[str, Any]:
        """results.json of the payload's latest job that succeeded."""
        answer: dict[str, Any] = self._http.get(f"payloads/{id_of(payload)}/results")
        return answer

    def export_payload(
        self, payload: Payload | str, form: str, target: str | Path, flange: Sequence[float] | None = None
    ) -> Path:
        """What was identified, written to `target`. form: json, csv, urdf, sdf, mjcf, ur, kuka or abb. flange: the
        sensor's pose in it, x, y, z [m], roll, pitch, yaw [°]; without it all is in the sensor's frame."""
        asked = httpx.QueryParams([("flange", repr(float(x))) for x in flange or ()])
        return self._http.download(f"payloads/{id_of(payload)}/exports/{quote(form)}?{asked}", Path(target))

    def upload_motion(
        self, capture: str | Path, skeleton: str | Path | None = None, static: str | Path | None = None,
        **said: str | None,
    ) -> Motion:  # fmt: skip
        """A capture (C3D, TRC, TSV, CSV, MVNX, MOT, STO, BVH; AMC with its ASF as skeleton). static: of markers, the
        person standing straight. said: up, unit, angle, subject, map, name, where the file is silent or wrong."""
        given = {"capture": capture, "skeleton": skeleton, "standing": static}
        files = {field: Path(path) for field, path in given.items() if path is not None}
        form = {key: value for key, value in said.items() if value is not None}
        form |= {} if static is None else {"static": Path(static).name}
        return thing(Motion, self._http.post("motions", files=files, form=form))

    def motions(self, name: str | None = None) -> Iterator[Motion]:
        """All motions, newest first; the versions of one name, where given."""
        return self._all("motions", Motion, {} if name is None else {"name": name})

    def fit_motion(self, motion: Motion | str) -> Job:
        """Ask for the body that fits a motion."""
        return thing(Job, self._http.post("jobs", {"motion_id": id_of(motion), "kind": "human_fit"}))

    def plan_motion(self, motion: Motion | str, robot: Robot | str, **options: Any) -> Plan:
        """Ask for the captured motion on a robot. options: begin, end, slow, repeat, mirror, share, without,
        what_would_do, rate_hz."""
        body = {"motion_id": id_of(motion), "robot_id": id_of(robot), "retarget": options}
        return thing(Plan, self._http.post("plans", body))

    def plan_excitation(self, robot: Robot | str, study: Study | str | None = None, **options: Any) -> Plan:
        """Ask for a motion from which a robot is identified well. study: whose logs are known already. options:
        seconds, seed."""
        known = {} if study is None else {"study_id": id_of(study)}
        return thing(Plan, self._http.post("plans", {"robot_id": id_of(robot), "excite": options} | known))

    def plans(self) -> Iterator[Plan]:
        """All plans, newest first."""
        return self._all("plans", Plan)

    def plan(self, plan: Plan | str) -> Plan:
        return thing(Plan, self._http.get(f"plans/{id_of(plan)}"))

    def wait_plan(self, plan: Plan | str, *, progress: bool = True, timeout_s: float | None = None) -> Plan:
        """Wait until it is made. Raises ClientProblem unless it was."""
        job = self.plan(plan).latest_job
        if job is not None:
            self.wait(str(job["id"]), progress=progress, timeout_s=timeout_s)
        return self.plan(plan)

    def export_plan(
        self, plan: Plan | str, form: str, target: str | Path, rate_hz: float | None = None, *, despite: bool = False
    ) -> Path:
        """The motion, written to `target`: the table for csv without a rate, else a zip of the format's files and of
        what tells of them. despite: although a bound is broken."""
        asked = {key: value for key, value in {"rate_hz": rate_hz, "despite": despite or None}.items() if value}
        path = f"plans/{id_of(plan)}/exports/{quote(form)}?{httpx.QueryParams(asked)}"
        return self._http.download(path, Path(target))

    def device(self, device: Device | str) -> Device:
        return thing(Device, self._http.get(f"devices/{id_of(device)}"))

    def jobs(self, study: Study | str | None = None, payload: Payload | str | None = None) -> Iterator[Job]:
        """All jobs, newest first; of one study or payload where given."""
        asked = {"study_id": study, "payload_id": payload}
        return self._all("jobs", Job, {key: id_of(owner) for key, owner in asked.items() if owner is not None})

    def study(self, study: Study | str) -> Study:
        return thing(Study, self._http.get(f"studies/{id_of(study)}"))

    def job(self, job: Job | str) -> Job:
        """The job as it is now, with its log."""
        return thing(Job, self._http.get(f"jobs/{id_of(job)}"))

    def submit(self, study: Study | str, kind: str = "evaluate", settings: Mapping[str, Any] | None = None) -> Job:
        """Ask for a job. An equal request that is queued, running or succeeded is the same job.

        kind: evaluate (every step that the study allows), support (up to the torque that a device gives), stiffness (up
        to its bands).
        """
        body = {"study_id": id_of(study), "kind": kind, "settings": dict(settings or {})}
        return thing(Job, self._http.post("jobs", body))

    def cancel(self, job: Job | str) -> Job:
        return thing(Job, self._http.post(f"jobs/{id_of(job)}/cancel"))

    def retry(self, job: Job | str) -> Job:
        """A new job with the request of a failed or cancelled one."""
        return thing(Job, self._http.post(f"jobs/{id_of(job)}/retry"))

    def wait(self, job: Job | str, *, progress: bool = True, timeout_s: float | None = None) -> Job:
        """Wait until the job has ended, with a bar on stderr. Raises ClientProblem unless it succeeded."""
        until = None if timeout_s is None else time.monotonic() + timeout_s
        with bar("queued", shown=progress) as say:
            while True:
                now = self.job(job)
                say(now.progress, now.message or now.place or "", now.stage or now.state)
                if now.ended:
                    break
                if until is not None and time.monotonic() > until:
                    raise NotNow(0, f"job {now.id} is still {now.state} after {timeout_s:.0f} s", now.message)
                time.sleep(POLL_S)
        if now.state != "succeeded":
            raise problem_of_job(now)
        return now

    def what_if(
        self,
        study: Study | str,
        log: str,
        changes: Sequence[Mapping[str, Any]] = (),
        *,
        device: str | None = None,
        main: Sequence[str] = (),
        series: bool = False,
    ) -> WhatIf:
        """What a changed device would do over a log of the study, beside what the present one does.

        changes: for example {"change": "stiffness", "of": "A", "to": 300.0}. device: a file of the study to start from,
        default what the log wears. main: joints that it is for. series: sample by sample too. At most 5000 samples; for
        all of them submit a job of kind `whatif`.
        """
        asked = {"log": log, "changes": [dict(change) for change in changes], "main": list(main), "series": series}
        given = asked | ({} if device is None else {"device": device})
        return thing(WhatIf, self._http.ask(f"studies/{id_of(study)}/whatif", given))

    def publish(
        self,
        study: Study | str,
        title: str,
        creators: Sequence[Mapping[str, str | None]],
        *,
        inputs: bool = False,
        follows: Publication | str | None = None,
        **about: Any,
    ) -> Publication:
        """What the study's latest evaluation found becomes a snapshot that anybody reads; said again, the same one.

        creators: [{"name": "Family, Given", "orcid"?, "affiliation"?}]. inputs: robot, logs and device too. follows: an
        earlier publication, of which it is the next version. about: description, keywords, licence, doi, job_id.
        """
        body = {"title": title, "creators": [dict(each) for each in creators], "inputs": inputs} | about
        earlier = {} if follows is None else {"follows": id_of(follows)}
        return thing(Publication, self._http.post(f"studies/{id_of(study)}/publications", body | earlier))

    def publications(self, study: Study | str | None = None) -> Iterator[Publication]:
        """What the lab has published, newest first; of one study, which may be gone, where given."""
        return self._all("publications", Publication, {} if study is None else {"study_id": id_of(study)})

    def revoke(self, publication: Publication | str, reason: str) -> Publication:
        """Its files go from the public at once; its record and the hashes stay. reason: told at its address."""
        return thing(Publication, self._http.post(f"publications/{id_of(publication)}/revoke", {"reason": reason}))

    def compare(self, jobs: Sequence[Job | str]) -> dict[str, Any]:
        """Jobs side by side: {jobs, support, stiffness, identification, settings}, one cell per job in each row."""
        answer: dict[str, Any] = self._http.get("compare", {"jobs": [id_of(job) for job in jobs]})
        return answer

    def comparison(self, jobs: Sequence[Job | str], form: str, table: str = "support") -> str:
        """One table of the same as text. form: csv (every digit) or latex (rounded by the standard deviations). table:
        support or stiffness."""
        return self._http.text("compare", {"jobs": [id_of(job) for job in jobs], "format": form, "table": table})

    def shares(self, study: Study | str) -> list[dict[str, Any]]:
        """Who else reads it: [{id, created_at, lab: its name, None for every lab}]."""
        return list(self._items(f"studies/{id_of(study)}/shares"))

    def share(self, study: Study | str, lab: str | None) -> dict[str, Any]:
        """Let a lab read it, by its name; None: every lab of the installation. Once is enough."""
        answer: dict[str, Any] = self._http.post(f"studies/{id_of(study)}/shares", {"lab": lab})
        return answer

    def end_share(self, study: Study | str, share: str) -> None:
        """share: its id."""
        self._http.delete(f"studies/{id_of(study)}/shares/{quote(share, safe='')}")

    def compared_devices(self) -> list[dict[str, Any]]:
        """Devices worn in studies that one may see, of most labs first: [{model, size, labs, studies}]."""
        return list(self._items("compare/devices"))

    def compare_device(self, model: str, size: str | None = None) -> dict[str, Any]:
        """One device over labs: {model, size, studies: who wore it on what and what each found, quantities: [{quantity,
        of, unit, rows, values, found: {labs, verdict, mean, std, q, i_squared, birge_ratio, tau, …}}]}."""
        asked = {"model": model} | ({} if size is None else {"size": size})
        answer: dict[str, Any] = self._http.get("compare/device", asked)
        return answer

    def models(self, study: Study | str) -> list[dict[str, Any]]:
        """Versions of the study's model, with the effects that were added to each."""
        return list(self._items(f"studies/{id_of(study)}/models"))

    def series(self, job: Job | str) -> list[dict[str, Any]]:
        """The job's series: [{name, log, samples, start, end, rate_hz, channels: [{name, unit, kind, words}]}]."""
        return list(self._items(f"jobs/{id_of(job)}/series"))

    def export_series(
        self,
        job: Job | str,
        name: str,
        target: str | Path,
        channels: Sequence[str] = (),
        start: float | None = None,
        end: float | None = None,
    ) -> Path:
        """Every sample of a window [s] of a series as CSV or Parquet, by the ending of `target`."""
        target = Path(target)
        form = "parquet" if target.suffix == ".parquet" else "csv"
        asked = {"channels": list(channels), "start": start, "end": end, "format": form}
        given = httpx.QueryParams({key: value for key, value in asked.items() if value is not None})
        return self._http.download(f"jobs/{id_of(job)}/series/{quote(name)}/window?{given}", target)

    def preview_log(
        self, upload: str, robot: Robot | str | None = None, mapping: Mapping[str, Any] | str | None = None
    ) -> dict[str, Any]:
        """What an uploaded log holds, what its columns may be, and with a mapping what the doctor says of it."""
        body = {"upload_id": upload, "robot_id": None if robot is None else id_of(robot), "mapping": mapping}
        answer: dict[str, Any] = self._http.ask("imports/preview", body)
        return answer

    def log_of_upload(
        self, upload: str, mapping: Mapping[str, Any] | str | None = None, robot: Robot | str | None = None
    ) -> Log:
        """A log that was uploaded before, read through its mapping."""
        body = {"upload_id": upload, "robot_id": None if robot is None else id_of(robot), "mapping": mapping}
        return thing(Log, self._http.post("logs/from-upload", body))

    def live(self, payload: Payload | str, rate_hz: float = 250.0) -> LiveStream:
        """A live stream of the payload's sensor (docs/payload.md)."""
        from exogauge.client.live import LiveStream

        return LiveStream(self.url, id_of(payload), rate_hz, token=self._token)

    def live_log(self, stream: str, target: str | Path) -> Path:
        """What an ended stream recorded, as Parquet with the columns of payload.yaml."""
        return self._http.download(f"streams/{stream}/log", Path(target))

    def robot_mapping(self, robot: Robot | str) -> dict[str, Any]:
        """The mapping kept for the robot's logs: {robot_id, mapping, yaml, changed_at}."""
        answer: dict[str, Any] = self._http.get(f"robots/{id_of(robot)}/mapping")
        return answer

    def keep_mapping(self, robot: Robot | str, mapping: Mapping[str, Any] | str) -> dict[str, Any]:
        """Keep a mapping for the robot's next logs."""
        answer: dict[str, Any] = self._http.put(f"robots/{id_of(robot)}/mapping", {"mapping": mapping})
        return answer

    def results(self, job: Job | str) -> dict[str, Any]:
        """results.json of a job."""
        answer: dict[str, Any] = self._http.get(f"jobs/{id_of(job)}/results")
        return answer

    def evaluated(self, of: Study | Job | str) -> Job:
        """The job itself; of a study its newest evaluation that succeeded. Raises ClientProblem 404."""
        key = id_of(of)
        if not isinstance(of, Study):
            try:
                return self.job(key)
            except ClientProblem as missing:
                if missing.status != 404:
                    raise
        study = self.study(key)
        ended = (job for job in self.jobs(study) if job.state == "succeeded" and job.kind != "whatif")
        if (newest := next(ended, None)) is None:
            raise ClientProblem(404, "Not found", f"no job of study {study.name!r} ({key}) has succeeded yet")
        return newest

    def artifacts(self, job: Job | str) -> list[Artifact]:
        return list(self._all(f"jobs/{id_of(job)}/artifacts", Artifact))

    def download(self, job: Job | str, folder: str | Path, names: list[str] | None = None) -> list[Path]:
        """Write the job's files below `folder`: all of them, or those named. Those that are there already stay;
        results.json comes last, so that where it stands, the files beside it belong to it."""
        wanted = [each for each in self.artifacts(job) if names is None or each.name in names]
        places = {each.name: below(Path(folder), each.name) for each in wanted}
        if RESULTS in places and any(not has(places[each.name], each.sha256) for each in wanted):
            places[RESULTS].unlink(missing_ok=True)
        for artifact in sorted(wanted, key=lambda each: each.name == RESULTS):
            self._http.download(quote(artifact.href), places[artifact.name], artifact.sha256)
        return list(places.values())

    def _all(self, path: str, kind: type[Thing], params: Mapping[str, Any] | None = None) -> Iterator[Thing]:
        return (thing(kind, item) for item in self._items(path, params))

    def _items(self, path: str, params: Mapping[str, Any] | None = None) -> Iterator[dict[str, Any]]:
        """Of all pages of a list."""
        cursor: str | None = None
        while True:
            page = self._http.get(path, {**(params or {}), **({"cursor": cursor} if cursor else {})})
            if "items" not in page:
                raise ClientProblem(0, f"{self.url} does not answer as exogauge does", f"there is no list at {path}")
            yield from page["items"]
            if (cursor := page.get("next_cursor")) is None:
                return

    def close(self) -> None:
        self._http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def id_of(thing: Robot | Device | Study | Payload | Motion | Plan | Job | Publication | str) -> str:
    """Records and plain ids are both accepted."""
    return thing if isinstance(thing, str) else thing.id


def below(folder: Path, name: str) -> Path:
    """`folder/name`, refused when the name would lead out of the folder."""
    target = (folder / name).resolve()
    if not target.is_relative_to(folder.resolve()):
        raise ClientProblem(0, "the service names a file outside the folder", name)
    return target
