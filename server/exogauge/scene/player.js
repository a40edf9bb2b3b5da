/* Stands between the page that shows a scene and viser's client, and runs before it.

   The client believes it is connected: the worker that would open its websocket is replaced by `Feed`, which hands it
   the scene's messages and, frame by frame, what moves. So any time can be shown at once, and nothing is requested.
   A seek pauses. Its number, `wish`, comes back with every time that is told after it: what was told before is old.

   page -> player   {type: "scene", data: ArrayBuffer}  {type: "seek", time, wish}  {type: "play", speed}  {type: "pause"}
                    {type: "camera"}
                    {type: "theme", dark}  {type: "show", layer, visible}  {type: "place", point, position}
                    {type: "choose", point}  {type: "settle"}
   player -> page   {type: "ready"}  {type: "loaded", about}  {type: "time", time, playing, wish}  {type: "failed", reason}
                    {type: "moved", point, link, position, done}  {type: "chosen", point}
                    {type: "settled"}: all that was asked before `settle` is drawn, letters and arrows too */
(() => {
  "use strict";
  const page = window.parent;
  const say = (message) => page.postMessage(message, location.origin);
  const state = { feed: null, scene: null, frame: -1, time: 0, playing: false, speed: 1, told: 0, wish: 0, before: 0, ready: 0, dark: false };

  class Feed extends EventTarget {
    constructor() {
      super();
      this.onmessage = null;
    }
    postMessage(asked) {
      if (asked.type === "set_server") setTimeout(() => connect(this));
      else if (asked.type === "send") heard(asked.message);
    }
    terminate() {}
    give(data) {
      if (this.onmessage) this.onmessage(new MessageEvent("message", { data }));
    }
  }
  window.Worker = Feed;

  function connect(feed) {
    state.feed = feed;
    feed.give({ type: "connected" });
    if (state.scene) show(true);
    else say({ type: "ready" });
  }

  const give = (messages) => state.feed && messages.length && state.feed.give({ type: "message_batch", messages });

  /* A scene: 8 bytes with the header's length, the header as JSON, then arrays; all begin at multiples of 8 bytes. */
  const KINDS = { "<f4": Float32Array, "<u4": Uint32Array, "|u1": Uint8Array };
  function opened(data) {
    const length = Number(new DataView(data).getBigUint64(0, true));
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 8, length)));
    const array = (place) => new KINDS[place.dtype](data, 8 + length + place.offset, place.length);
    const filled = (value) => {
      if (Array.isArray(value)) return value.map(filled);
      if (value === null || typeof value !== "object") return value;
      if ("__array" in value) return array(value.__array).slice();
      return Object.fromEntries(Object.entries(value).map(([key, each]) => [key, filled(each)]));
    };
    const tracks = header.tracks.map((track) => ({ ...track, values: array(track.values), shown: null }));
    return { ...header, messages: filled(header.messages), tracks };
  }

  async function load(packed) {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const scene = opened(await new Response(stream).arrayBuffer());
    const first = !state.scene;
    Object.assign(state, { scene, time: scene.start, playing: false });
    if (!first && state.feed) state.feed.give({ type: "connected" }); // the client forgets what it shows
    show(first);
    const { log, start, end, fps, frames, legend, marked, notes, points, hidden } = state.scene;
    const layers = Object.keys(state.scene.layers).filter((name) => state.scene.layers[name].length);
    say({ type: "loaded", about: { log, start, end, fps, frames, legend, marked, notes, points, layers, hidden } });
  }

  function show(aim) {
    give([theme(), ...state.scene.messages, ...(aim ? camera() : [])]);
    for (const track of state.scene.tracks) track.shown = null;
    state.frame = -1;
    seek(state.time);
    state.ready = performance.now() + NUDGES.at(-1);
    for (const pause of NUDGES) setTimeout(() => give([theme()]), pause);
  }

  /* [ms] The client draws only when told something; letters and arrows that were made ready later would stay unseen. */
  const NUDGES = [300, 1000, 3000, 8000];

  /* The client draws a frame after it was told something, and shows it one later. */
  const DRAWN = 4;
  function settle(frames) {
    if (!state.scene || performance.now() < state.ready) setTimeout(() => settle(DRAWN), 100);
    else if (frames === 0) say({ type: "settled" });
    else {
      if (frames === DRAWN) give([theme()]);
      requestAnimationFrame(() => settle(frames - 1));
    }
  }

  const theme = () => ({
    type: "ThemeConfigurationMessage", titlebar_content: null, control_layout: "floating", control_width: "small",
    show_logo: false, show_share_button: false, dark_mode: state.dark, colors: null,
  });

  const camera = () => [
    { type: "SetCameraLookAtMessage", look_at: state.scene.camera.look_at, initial: false },
    { type: "SetCameraPositionMessage", position: state.scene.camera.position, initial: false },
  ];

  function seek(time) {
    const { scene } = state;
    if (!scene) return;
    state.time = Math.min(Math.max(time, scene.start), scene.end);
    const frame = Math.min(Math.max(Math.round((state.time - scene.start) * scene.fps), 0), scene.frames - 1);
    if (frame === state.frame) return;
    state.frame = frame;
    give(scene.tracks.flatMap((track) => changed(track, frame)));
  }

  /* What of a track differs from what is shown, as messages. */
  function changed(track, frame) {
    const at = Math.min(frame * track.width, track.values.length - track.width); // one row: it never changes
    const row = track.values.subarray(at, at + track.width);
    if (track.shown && row.every((value, k) => value === track.shown[k])) return [];
    track.shown = row;
    return SHOWN[track.kind](track, row);
  }

  const properties = (name, updates) => ({ type: "SceneNodeUpdateMessage", name, updates, owner: "" });
  const visible = (name, yes) => ({ type: "SetSceneNodeVisibilityMessage", name, visible: yes, owner: "" });
  const SHOWN = {
    turn: ({ name }, row) => [{ type: "SetOrientationMessage", name, wxyz: [...row], owner: "" }],
    place: ({ name }, row) => [{ type: "SetPositionMessage", name, position: [...row], owner: "" }],
    visible: ({ name }, row) => [visible(name, row[0] > 0)],
    points: ({ name }, row) => [properties(name, { points: row.slice() })],
    colors: ({ name }, row) => [properties(name, { colors: row.slice() })],
    arc: ({ name, radius }, row) => [properties(name, { points: arc(radius, row[0]) })],
  };

  /* An arrow bent round the z axis of its node; angle [rad], with its sign. Always as many segments. */
  const PIECES = 18, SEEN = 0.12;
  function arc(radius, angle) {
    if (Math.abs(angle) < SEEN) return new Float32Array((PIECES + 2) * 6); // it would be all head
    const at = (a, r) => [r * Math.cos(a), r * Math.sin(a), 0];
    const points = [];
    for (let k = 0; k < PIECES; k++)
      points.push(...at((angle * k) / PIECES, radius), ...at((angle * (k + 1)) / PIECES, radius));
    const head = Math.min(0.35, Math.abs(angle) / 2);
    const back = angle - Math.sign(angle) * head;
    for (const r of [1 - 0.6 * head, 1 + 0.6 * head]) points.push(...at(angle, radius), ...at(back, radius * r));
    return new Float32Array(points);
  }

  /* What the client would tell a server: only a via point that was dragged matters. */
  let dragged = null;
  function heard(message) {
    const points = state.scene?.points ?? [];
    if (message.type === "SceneNodeClickMessage") choose(points.findIndex((each) => each.ball === message.name));
    const point = points.findIndex((each) => each.name === message.name);
    if (point < 0) return;
    if (message.type === "TransformControlsUpdateMessage") dragged = place(point, [...message.position]);
    else if (message.type !== "TransformControlsDragEndMessage" || !dragged) return;
    const done = message.type === "TransformControlsDragEndMessage";
    say({ type: "moved", point, link: state.scene.points[point].link, position: dragged, done });
  }

  /* Only the chosen point shows the arrows that it is dragged by; -1: none does. */
  function choose(point) {
    give(state.scene.points.map((each, k) => visible(each.name, k === point)));
    say({ type: "chosen", point });
  }

  /* A via point at another place in its link's frame: the band follows. */
  function place(index, position) {
    const point = state.scene.points[index];
    point.position = position;
    const route = state.scene.points.filter((each) => each.band === point.band).map(world);
    const segments = route.slice(1).flatMap((end, k) => [...route[k], ...end]);
    const ball = { type: "SetPositionMessage", name: point.ball, position, owner: "" };
    give([ball, properties(point.line, { points: new Float32Array(segments) })]);
    return position;
  }
  const world = ({ rotation, origin, position }) =>
    origin.map((o, i) => o + rotation[i].reduce((sum, r, k) => sum + r * position[k], 0));

  function tick(now) {
    const passed = (now - state.before) / 1000;
    state.before = now;
    if (state.playing && state.scene) {
      const { start, end } = state.scene;
      const time = state.time + passed * state.speed;
      seek(time > end ? start : time);
      if (now - state.told > 30) tell(now);
    }
    requestAnimationFrame(tick);
  }
  function tell(now) {
    state.told = now;
    say({ type: "time", time: state.time, playing: state.playing, wish: state.wish });
  }

  const DOES = {
    scene: ({ data }) => load(data).catch((error) => say({ type: "failed", reason: String(error) })),
    seek: ({ time, wish }) => {
      Object.assign(state, { playing: false, wish });
      seek(time);
      tell(performance.now());
    },
    play: ({ speed }) => Object.assign(state, { playing: true, speed: speed ?? 1 }),
    pause: () => {
      state.playing = false;
      tell(performance.now());
    },
    settle: () => settle(DRAWN),
    camera: () => { if (state.scene) give(camera()); },
    choose: ({ point }) => { if (state.scene?.points) choose(point); },
    theme: ({ dark }) => { state.dark = dark; give([theme()]); },
    show: ({ layer, visible: yes }) => give((state.scene?.layers[layer] ?? []).map((name) => visible(name, yes))),
    place: ({ point, position }) => {
      place(point, position);
      give([{ type: "SetPositionMessage", name: state.scene.points[point].name, position, owner: "" }]);
    },
  };
  window.addEventListener("message", (event) => {
    if (event.source === page && event.data && event.data.type in DOES) DOES[event.data.type](event.data);
  });
  window.addEventListener("error", (event) => say({ type: "failed", reason: event.message }));
  if (!document.createElement("canvas").getContext("webgl2")) say({ type: "failed", reason: "webgl" });
  requestAnimationFrame(tick);
})();
