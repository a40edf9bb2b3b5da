// The plain page: lists studies, hands one in, starts and stops its evaluation, links what came out.
// Every address is relative to the page, so that it works below any path.

const API = "api/v1/";
const ACTIVE = ["queued", "running"];
const WORDS = {
  queued: "Waiting", running: "Running", succeeded: "Done", failed: "Failed", cancelled: "Cancelled",
};
const $ = (id) => document.getElementById(id);
const shown = new Map(); // study id -> what is on the page for it
let older = null; // cursor of the next page
let olderAsked = false;
let timer = null;

class Refusal extends Error {
  constructor(problem) {
    super(problem.detail || problem.title);
    this.problem = problem;
  }
}

function newKey() {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

async function ask(path, options = {}) {
  const headers = { Accept: "application/json", ...options.headers };
  if (options.method === "POST") headers["Idempotency-Key"] = newKey();
  let response;
  try {
    response = await fetch(path, { ...options, headers });
  } catch {
    throw new Refusal({ title: "No answer", detail: "The service does not answer. Is it still running?" });
  }
  const body = await response.json().catch(() => ({}));
  if (!response.ok) throw new Refusal({ title: `${response.status} ${response.statusText}`, ...body });
  return body;
}

function element(name, text, properties = {}) {
  const made = Object.assign(document.createElement(name), properties);
  if (text !== undefined) made.textContent = text;
  return made;
}

// ---- problems -----------------------------------------------------------------------------------------------------

function placeOf(error) {
  const parts = [];
  if (error.file) parts.push(error.file);
  if (error.row !== null && error.row !== undefined) parts.push(`row ${error.row}`);
  if (error.column) parts.push(`column ${error.column}`);
  return parts.length ? parts.join(", ") : error.pointer || "";
}

function showRefusal(where, error) {
  const problem = error instanceof Refusal ? error.problem : { title: "The page failed", detail: String(error) };
  const box = element("div", undefined, { className: "refusal" });
  box.append(element("h4", problem.title));
  const errors = problem.errors || [];
  if (!errors.length) box.append(element("p", problem.detail));
  const list = element("ul");
  for (const error of errors.slice(0, 50)) {
    const line = element("li");
    const place = placeOf(error);
    if (place) line.append(element("strong", place), ": ");
    line.append(error.detail);
    if (error.value) line.append(" (value: ", element("code", error.value), ")");
    line.append(". ");
    if (error.advice) line.append(error.advice);
    list.append(line);
  }
  if (errors.length) box.append(list);
  where.replaceChildren(box);
}

// ---- handing in ---------------------------------------------------------------------------------------------------

function upload(file, progress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch cannot say how much was sent
    request.open("POST", `${API}studies`);
    request.setRequestHeader("Idempotency-Key", newKey());
    request.responseType = "json";
    request.upload.onprogress = (event) => progress(event.loaded / event.total);
    request.onerror = () => reject(new Refusal({ title: "No answer", detail: "The upload broke off. Try again." }));
    request.onload = () => {
      const body = request.response || {};
      if (request.status < 300) resolve({ study: body, isNew: request.status === 201 });
      else reject(new Refusal({ title: `${request.status} ${request.statusText}`, ...body }));
    };
    const form = new FormData();
    form.append("files", file, file.name);
    request.send(form);
  });
}

async function handIn(event) {
  event.preventDefault();
  const [form, outcome] = [event.target, $("outcome")];
  const button = form.querySelector("button");
  button.disabled = true;
  outcome.replaceChildren();
  $("sending").hidden = false;
  try {
    const { study, isNew } = await upload($("bundle").files[0], (part) => {
      $("sent").value = part;
      $("sent-words").textContent = part < 1 ? `${Math.round(part * 100)} % sent` : "sent; its files are being read …";
    });
    const words = isNew ? `“${study.name}” is stored.` : `“${study.name}” was stored before: the same files.`;
    outcome.replaceChildren(element("p", words, { className: "accepted" }));
    form.reset();
    if ($("run-at-once").checked && !study.latest_job) await submit(study.id);
    await refresh();
  } catch (error) {
    showRefusal(outcome, error);
    outcome.focus();
  } finally {
    button.disabled = false;
    $("sending").hidden = true;
  }
}

// ---- one study ----------------------------------------------------------------------------------------------------

function submit(studyId) {
  const body = JSON.stringify({ study_id: studyId, kind: "evaluate", settings: {} });
  return ask(`${API}jobs`, { method: "POST", body, headers: { "Content-Type": "application/json" } });
}

function place(study) {
  const item = $("study").content.cloneNode(true).firstElementChild;
  const entry = { item, study, part: (name) => item.querySelector(`.${name}`) };
  entry.part("run").addEventListener("click", () => act(entry, () => submit(entry.study.id)));
  entry.part("cancel").addEventListener("click", () =>
    act(entry, () => ask(`${API}jobs/${entry.study.latest_job.id}/cancel`, { method: "POST" })));
  whenOpened(entry, "files", () => listFiles(entry));
  whenOpened(entry, "fit", () => showFit(entry));
  whenOpened(entry, "pinned", () => listPinned(entry));
  shown.set(study.id, entry);
  return entry;
}

async function act(entry, action) {
  const buttons = entry.item.querySelectorAll("button");
  buttons.forEach((button) => { button.disabled = true; });
  entry.part("problem").replaceChildren();
  try {
    await action();
    await refresh();
  } catch (error) {
    showRefusal(entry.part("problem"), error);
  } finally {
    buttons.forEach((button) => { button.disabled = false; });
  }
}

function whenOpened(entry, name, fill) {
  const details = entry.part(name);
  details.addEventListener("toggle", () => {
    if (!details.open) return;
    fill().catch((error) => showRefusal(entry.part("problem"), error));
  });
}

function draw(entry, study) {
  const before = entry.study.latest_job;
  entry.study = study;
  const job = study.latest_job;
  const robot = study.summary.robot || {};
  const logs = study.summary.logs || [];
  entry.part("name").textContent = study.name;
  const facts = [new Date(study.created_at).toLocaleString()];
  if (robot.name) facts.push(`${robot.name}, ${count(robot.joints.length, "joint")}, ${robot.base} base`);
  if (logs.length) facts.push(count(logs.length, "log"));
  for (const device of study.summary.devices || []) facts.push(deviceWords(device));
  facts.push(`content ${study.content_hash.slice(0, 12)}`);
  entry.part("facts").textContent = facts.join(" · ");

  const active = Boolean(job) && ACTIVE.includes(job.state);
  const done = Boolean(job) && job.state === "succeeded";
  const badge = entry.part("badge");
  badge.textContent = job ? WORDS[job.state] : "Not run yet";
  badge.dataset.state = job ? job.state : "none";
  const bar = entry.item.querySelector("progress");
  bar.hidden = !job || job.state !== "running";
  bar.value = job ? job.progress : 0;
  entry.part("message").textContent = job ? messageOf(job) : "";
  entry.part("run").hidden = active || done;
  entry.part("run").textContent = job ? "Run again" : "Run";
  entry.part("run").setAttribute("aria-label", `${job ? "Run again" : "Run"}: ${study.name}`);
  entry.part("cancel").hidden = !active;
  entry.part("cancel").setAttribute("aria-label", `Cancel: ${study.name}`);
  if (job && job.problem && entry.told !== job.id) {
    entry.told = job.id;
    showRefusal(entry.part("problem"), new Refusal(job.problem));
  }
  const evaluated = done && job.kind !== "whatif";
  link(entry.part("report"), evaluated, () => `${API}jobs/${job.id}/artifacts/report.html`);
  link(entry.part("results"), evaluated, () => `${API}jobs/${job.id}/results`);
  for (const name of ["files", "fit"]) {
    entry.part(name).hidden = !(name === "fit" ? evaluated : done);
    if (before && job && before.id !== job.id) entry.part(name).open = false;
  }
}

function deviceWords(device) {
  const { bands = [], groups = [], joints = [] } = device.bands ? device : device.summary;
  return `${device.name}: ${count(bands.length, "band")} in ${count(groups.length, "group")} on ${joints.join(", ")}`;
}

async function listDevices() {
  const { items } = await ask(`${API}devices?limit=20`);
  $("devices-part").hidden = !items.length;
  $("devices").replaceChildren(...items.map((device) => {
    const line = element("li", `${deviceWords(device)} (version ${device.version})`);
    const doubts = (device.summary.warnings || []).map((doubt) => `${placeOf(doubt)}: ${doubt.detail}. ${doubt.advice}`);
    line.append(...doubts.map((text) => element("div", text, { className: "quiet" })));
    return line;
  }));
}

function count(number, noun) {
  return `${number} ${noun}${number === 1 ? "" : "s"}`;
}

function messageOf(job) {
  if (job.state === "running") return `${Math.round(job.progress * 100)} % ${job.message}`;
  if (job.problem) return ""; // it has a box of its own
  if (job.state === "failed" || job.state === "cancelled") return job.reason || "";
  if (job.state === "succeeded") return took(job);
  return job.message;
}

function took(job) {
  const seconds = (new Date(job.finished_at) - new Date(job.started_at)) / 1000;
  return Number.isFinite(seconds) ? `in ${seconds < 90 ? `${seconds.toFixed(1)} s` : `${(seconds / 60).toFixed(1)} min`}` : "";
}

function link(anchor, there, href) {
  anchor.hidden = !there;
  if (there) anchor.href = href();
}

async function listFiles(entry) {
  const { items } = await ask(`${API}jobs/${entry.study.latest_job.id}/artifacts`);
  const lines = items.map((file) => {
    const line = element("li");
    const href = API + file.href.split("/").map(encodeURIComponent).join("/");
    line.append(element("a", file.name, { href }), ` ${sizeOf(file.size)}`);
    return line;
  });
  entry.item.querySelector(".files ul").replaceChildren(...lines);
}

async function listPinned(entry) {
  const { files } = await ask(`${API}studies/${entry.study.id}`);
  const lines = files.map((file) => {
    const line = element("li", `${file.path} (${sizeOf(file.size)}) `);
    line.append(element("code", file.sha256));
    return line;
  });
  entry.item.querySelector(".pinned ul").replaceChildren(...lines);
}

function sizeOf(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

async function showFit(entry) {
  const results = await ask(`${API}jobs/${entry.study.latest_job.id}/results`);
  const { validation: rows = [], summary = [] } = results.identification || {};
  const lines = summary.map((each) => element("p",
    `${each.kind.replace("_", " ")}, ${each.held_out ? "all held-out logs" : "fitted logs"}: `
    + `${numberOf(each.rmse_prior)} → ${numberOf(each.rmse_identified)} ${each.unit}, noise floor ${numberOf(each.noise_floor)}`));
  const fits = tableOf(
    "Root mean square of measured minus predicted; held-out logs were never fitted.",
    ["Channel", "Log", "Maker’s values", "Identified", "In steady motion", "Noise floor", "Unit"],
    rows.map((row) => [row.channel, `${row.log}${row.held_out ? " (held out)" : ""}`,
      ...["rmse_prior", "rmse_identified", "rmse_moving", "noise_floor"].map((key) => numberOf(row[key])), row.unit]),
  );
  const tables = [supportTable(results.support), stiffnessTable(results.stiffness)].filter(Boolean);
  entry.part("table").replaceChildren(
    ...tables, ...lines, rows.length ? fits : element("p", "The result holds no validation."));
}

function supportTable(rows = []) {
  return rows.length && tableOf(
    "Supporting torque: its peak, and RMSE against the band model by approach, N·m. Motions are compared for A.",
    ["Joint", "Motion", "Device", "Peak", "A", "B", "Maker’s values", "Motions"],
    rows.map((row) => [row.joint, row.motion, row.device, withStd(row.peak),
      ...["rmse_a", "rmse_b", "rmse_prior"].map((key) => numberOf(row[key])),
      row.motion_equality ? row.motion_equality.verdict : "–"]),
  );
}

function stiffnessTable(rows = []) {
  return rows.length && tableOf(
    "Stiffness and natural length of each band, from the torque by each approach.",
    ["Band", "Device", "Approach", "Stiffness, N/m", "Length, m", "Error, %"],
    rows.map((row) => [row.band, row.device, row.approach, withStd(row.stiffness_n_per_m),
      withStd(row.natural_length_m), numberOf(row.error_percent)]),
  );
}

function tableOf(caption, heads, rows) {
  const table = element("table");
  table.append(element("caption", caption));
  const head = element("tr");
  head.append(...heads.map((text) => element("th", text, { scope: "col" })));
  table.createTHead().append(head);
  const body = table.createTBody();
  for (const [first, ...cells] of rows) {
    const line = body.insertRow();
    line.append(element("th", first, { scope: "row" }), ...cells.map((text) => element("td", text)));
  }
  return table;
}

function withStd(entry) {
  return entry && typeof entry.std === "number" ? `${numberOf(entry)} ± ${Number(entry.std.toPrecision(2))}` : numberOf(entry);
}

function numberOf(entry) {
  const value = entry !== null && typeof entry === "object" ? entry.value : entry;
  return typeof value === "number" ? value.toPrecision(3) : "–";
}

// ---- the list -----------------------------------------------------------------------------------------------------

async function refresh() {
  clearTimeout(timer);
  try {
    const page = await ask(`${API}studies?limit=20`);
    if (!olderAsked) older = page.next_cursor;
    const list = $("list");
    let next = list.firstElementChild;
    for (const study of page.items) {
      const known = shown.get(study.id);
      const entry = known || place(study);
      draw(entry, study);
      if (entry.item === next) next = next.nextElementSibling;
      else list.insertBefore(entry.item, next);
    }
    const fresh = new Set(page.items.map((study) => study.id));
    for (const [id, entry] of shown) {
      const job = entry.study.latest_job;
      if (!fresh.has(id) && job && ACTIVE.includes(job.state)) draw(entry, await ask(`${API}studies/${id}`));
    }
    $("none").hidden = shown.size > 0;
    $("more").hidden = !older;
    await Promise.all([showHealth(), listDevices()]);
  } catch (error) {
    $("health").textContent = error.message;
  }
  const busy = [...shown.values()].some(({ study }) => study.latest_job && ACTIVE.includes(study.latest_job.state));
  timer = setTimeout(refresh, document.hidden ? 30000 : busy ? 1000 : 8000);
}

async function showOlder() {
  const page = await ask(`${API}studies?limit=20&cursor=${encodeURIComponent(older)}`);
  olderAsked = true;
  older = page.next_cursor;
  for (const study of page.items) {
    const entry = shown.get(study.id) || place(study);
    draw(entry, study);
    $("list").append(entry.item);
  }
  $("more").hidden = !older;
}

async function showHealth() {
  const response = await fetch("healthz");
  const health = await response.json();
  const workers = `${count(health.workers_alive, "worker")} of ${health.workers_wanted}`;
  const said = {
    ok: `Service ${health.version}, ${workers}.`,
    degraded: health.workers_alive ? `Service ${health.version}, only ${workers}: jobs may wait.`
      : `Service ${health.version}, no worker is there yet: jobs wait.`,
    unavailable: `Cannot serve now: database ${health.database}, storage ${health.blobs}.`,
  };
  const words = said[health.status] || "The service answers oddly.";
  if ($("health").textContent !== words) $("health").textContent = words;
}

$("hand-in").addEventListener("submit", handIn);
$("more").addEventListener("click", () => showOlder().catch((error) => showRefusal($("outcome"), error)));
document.addEventListener("visibilitychange", () => { if (!document.hidden) refresh(); });
refresh();
