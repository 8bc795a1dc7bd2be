// A made-up bench behind the page's protocol, to work on the page without hil: npm run fake [-- DEVICES [PORT]].
import { createHash, randomInt } from "node:crypto";
import { createReadStream, existsSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { WebSocketServer } from "ws";

const COUNT = Number(process.argv[2] ?? 4);
const PORT = Number(process.argv[3] ?? 8765);
const FOLDER = process.env.HIL_WEB_OUT ?? join(import.meta.dirname, "../../bridges/web/static");
const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".json": "application/json" };
const CSP =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'";
const begun = performance.now();
const now_s = () => (performance.now() - begun) / 1000;
const version = () => process.env.FAKE_VERSION ?? JSON.parse(readFileSync(join(FOLDER, "build.json"), "utf8")).version;

const field = (name, unit, meaning, type = "f64", more = {}) => ({ name, type, unit, meaning, is_settable: false, is_state: true, ...more });
const FIELDS = [
  field("at_ns", "ns", "simulated time of this snapshot", "i64"),
  field("position_deg", "deg", "shaft angle with turns"),
  field("velocity_rpm", "rpm", "shaft speed"),
  field("torque_Nm", "Nm", "torque of the motor on the shaft"),
  field("current_a_A", "A", "current of coil A"),
  field("current_b_A", "A", "current of coil B"),
  field("r", "deg", "set-point: deg in x and h, rpm in v, counts in t", "f32"),
  field("in1", "", "driver pin IN_1", "i32"),
  field("pin_step", "", "input step; of a servo D1", "i32"),
  field("pKp", "", "position loop, proportional gain", "f32", { is_settable: true }),
];
const number = (name, summary, unit, minimum, maximum, more = {}) => ({
  name,
  summary,
  type: "number",
  unit,
  minimum,
  maximum,
  default: null,
  choices: [],
  ...more,
});
const VERBS = {
  position: { summary: "set-point of the position", role: "operator", parameters: [number("position_deg", "the angle", "deg", -1e6, 1e6)] },
  mode: {
    summary: "choose what the set-point means",
    role: "operator",
    parameters: [{ name: "mode", summary: "of the control law", type: "choice", unit: "", choices: ["position", "velocity"], default: null }],
  },
  enable: { summary: "start the control loop", role: "operator", parameters: [] },
  gains: {
    summary: "set gains",
    role: "operator",
    parameters: ["pKp", "pKi", "pKd"].map((name) => number(name, "as the firmware has it", "", 0, 1e6, { is_optional: true })),
  },
  move_abs: {
    summary: "go to an angle with ramps",
    role: "operator",
    parameters: [number("position_deg", "where to", "deg", -1e6, 1e6), number("velocity_rpm", "speed on the way", "rpm", 0.001, 3000, { default: 60 })],
  },
};
const NAMES = ["m1", "<b>bold</b>", '‮evil‬ "quote" & co', "s1"];
const device = (_, at) => ({
  name: NAMES[at] ?? `axis${at}`,
  profile: at % 2 ? "sac" : "mechaduino",
  is_real: at === 2,
  is_seen: true,
  verbs: VERBS,
  fields: FIELDS,
  inputs: { step: "pin_step", dir: "" },
});
const DEVICES = Array.from({ length: COUNT }, device);
const KINDS = [
  {
    name: "byte_flip",
    layer: "byte",
    target: "port",
    summary: "bits of bytes are inverted",
    parameters: [number("rate", "probability for each bit", "", 0, 1)],
  },
  {
    name: "shaft_load",
    layer: "physics",
    target: "shaft",
    summary: "a torque on the shaft",
    parameters: [number("torque_Nm", "positive towards larger counts", "Nm", -1000, 1000)],
  },
  { name: "node_reset", layer: "node", target: "device", summary: "the power goes and comes back, once", is_once: true, parameters: [] },
];
const shafts = new Map(DEVICES.map((each, at) => [each.name, { setpoint: 0, from: 0, at_s: 0, kp: 15, phase: at }]));
const faults = [];
const runs = [];
let nextFault = 1;

function reading(name, at_s) {
  const shaft = shafts.get(name);
  const after = Math.max(0, at_s - shaft.at_s);
  const damping = 6 + shaft.kp / 5;
  const wave = Math.sin(at_s * (1 + shaft.phase / 10)) * 90;
  const step = shaft.setpoint - shaft.from;
  const still = shaft.setpoint ? shaft.from + step * (1 - Math.exp(-damping * after) * Math.cos(40 * after)) : wave;
  return {
    at_ns: at_s * 1e9,
    position_deg: still + (randomInt(100) - 50) / 1000,
    velocity_rpm: shaft.setpoint ? 0 : Math.cos(at_s * (1 + shaft.phase / 10)) * 15,
    torque_Nm: Math.cos(at_s * 3) * 0.02,
    current_a_A: Math.cos(at_s * 8),
    current_b_A: Math.sin(at_s * 8),
    r: shaft.setpoint || wave,
    in1: Math.floor(at_s * 2) % 2,
    pin_step: Math.floor(at_s * 5) % 2,
    pKp: shaft.kp,
  };
}

const status = () => ({
  bench: "fake",
  sim_ns: Math.round(now_s() * 1e9),
  elapsed_ns: Math.round(now_s() * 1e9),
  speed: 1,
  rate_hz: 1000,
  health: { state: "ok", late_ms: 0.4, problems: [] },
  devices: DEVICES.map(({ name }) => ({
    device: name,
    failed: null,
    clients: 1,
    rx_bytes: now_s() * 90,
    tx_bytes: now_s() * 400,
    dropped_bytes: 0,
    snapshot: reading(name, now_s() - 0.0012),
  })),
});

const hello = () => ({
  hello: {
    protocol: 1,
    version: version(),
    bench: "fake",
    user: "",
    role: process.env.FAKE_ROLE ?? "admin",
    devices: DEVICES,
    segments: ["bus0"],
    buses: [],
    ports: DEVICES.map(({ name }) => name),
    operations: {},
    fault_kinds: KINDS,
  },
});

class Refused extends Error {}

const OPERATIONS = {
  status,
  state: (target) => reading(target, now_s()),
  faults: () => faults,
  do: (target, { name, parameters }) => {
    const shaft = shafts.get(target);
    if (name === "gains" && parameters.pKp !== undefined) shaft.kp = parameters.pKp;
    if (name === "position" || name === "move_abs")
      Object.assign(shaft, { from: reading(target, now_s()).position_deg, setpoint: parameters.position_deg, at_s: now_s() });
    return { effective_at_ns: now_s() * 1e9 };
  },
  inject: (target, { fault, parameters }) => {
    if (fault !== "node_reset") faults.push({ number: nextFault, kind: fault, target, parameters });
    changed();
    return { number: nextFault++ };
  },
  clear: (_target, { number }) => {
    faults.splice(0, faults.length, ...faults.filter((each) => number !== "all" && each.number !== number));
    changed();
    return {};
  },
  run: (_target, { text, check }) => {
    const lines = text.split("\n");
    const bad = lines.findIndex((line) => line.includes("nowhere"));
    if (bad >= 0) return { problems: `<run>:${bad + 1}:5: steps.0.move: there is no axis nowhere` };
    if (check) return { run: "fake", steps: 4 };
    const run = {
      run: `fake-${runs.length + 1}`,
      state: "running",
      step: 1,
      steps: 4,
      planned_end_ns: (now_s() + 4) * 1e9,
      why: null,
      axes: { m1: { target_deg: 90, position_deg: 1, error_max_deg: 0.1, error_rms_deg: 0.05, at_end: null } },
    };
    runs.push(run);
    const timer = setInterval(() => {
      if (run.state === "running") run.step++;
      if (run.step >= run.steps) run.state = "done";
      if (run.state !== "running") clearInterval(timer);
      for (const client of clients) client.push("runs", { items: [run], lost: 0 });
    }, 500);
    return run;
  },
  runs: () => runs,
  cancel_run: (target) =>
    Object.assign(
      runs.find(({ run }) => run === target),
      { state: "cancelled", why: "cancelled by the page" },
    ),
  pin: () => ({}),
  set: () => ({}),
};

const clients = new Set();
const changed = () => {
  for (const client of clients) client.push("faults", { value: faults });
};

class Client {
  constructor(socket) {
    this.socket = socket;
    this.watches = new Map();
    this.next = 1;
    clients.add(this);
    socket.on("close", () => {
      clients.delete(this);
      for (const { timer } of this.watches.values()) clearInterval(timer);
    });
    socket.on("message", (data, isBinary) => (isBinary ? this.typed(data) : this.asked(JSON.parse(String(data)))));
    this.send(hello());
  }

  send(message) {
    this.socket.send(JSON.stringify(message));
  }

  push(what, message) {
    for (const [watch, each] of this.watches) if (each.what === what) this.send({ watch, ...message });
  }

  asked({ id, ...request }) {
    try {
      this.send({ id, answer: this.answer(request) ?? {} });
    } catch (error) {
      this.send({ id, error: { code: "bad_parameter", message: String(error.message) } });
    }
  }

  answer(request) {
    if (request.do === "watch") return this.watch(request);
    if (request.do === "unwatch") return (clearInterval(this.watches.get(request.watch)?.timer), this.watches.delete(request.watch), {});
    if (request.do === "open") return this.open();
    if (request.do !== "ask") return {};
    const operation = OPERATIONS[request.operation];
    if (!operation) throw new Refused(`there is no operation ${request.operation}`);
    return operation(request.target, request.given);
  }

  open() {
    const terminal = this.next++;
    setTimeout(() => this.socket.send(Buffer.concat([head(terminal), Buffer.from("board>\r\n\x1b[31mred\x1b]0;title\x07 \xff", "latin1")])), 50);
    return { terminal, baud: 115200 };
  }

  typed(frame) {
    this.socket.send(Buffer.concat([head(frame.readUInt32LE(4)), frame.subarray(8)]));
  }

  watch({ what, target, fields, rate_Hz }) {
    const watch = this.next++;
    const each = { what, timer: 0 };
    this.watches.set(watch, each);
    if (what === "samples") each.timer = this.samples(watch, target, fields, rate_Hz);
    if (what === "clock") each.timer = setInterval(() => this.send({ watch, value: performance.now() }), 500);
    if (what === "status") each.timer = setInterval(() => this.send({ watch, value: status() }), 1000 / rate_Hz);
    if (what === "faults") setTimeout(() => this.send({ watch, value: faults }));
    return { watch };
  }

  samples(watch, target, fields, rate_Hz) {
    let last = Math.floor(now_s() * rate_Hz);
    return setInterval(() => {
      const until = Math.floor(now_s() * rate_Hz);
      const rows = until - last;
      if (rows <= 0 || this.socket.bufferedAmount > 1e6) return;
      const frame = Buffer.alloc(16 + rows * (1 + fields.length) * 8);
      frame[0] = 1;
      frame[1] = fields.length;
      frame.writeUInt32LE(watch, 4);
      frame.writeUInt32LE(rows, 12);
      let at = 16;
      for (let row = last + 1; row <= until; row++) {
        const read = reading(target, row / rate_Hz);
        at = frame.writeDoubleLE(row / rate_Hz, at);
        for (const name of fields) at = frame.writeDoubleLE(read[name] ?? NaN, at);
      }
      last = until;
      this.socket.send(frame);
    }, 16);
  }
}

function head(terminal) {
  const bytes = Buffer.alloc(8);
  bytes[0] = 2;
  bytes.writeUInt32LE(terminal, 4);
  return bytes;
}

const server = createServer((request, response) => {
  const path = new URL(request.url, "http://x").pathname;
  const headers = { "Content-Security-Policy": CSP, "Cache-Control": "no-cache" };
  if (path === "/api/hello")
    return response.writeHead(200, { ...headers, "Content-Type": "application/json" }).end(JSON.stringify({ version: version(), login: "none" }));
  const file = join(FOLDER, normalize(path === "/" ? "/index.html" : path));
  if (!file.startsWith(FOLDER) || !existsSync(file)) return response.writeHead(404, headers).end();
  response.writeHead(200, {
    ...headers,
    "Content-Type": TYPES[extname(file)] ?? "application/octet-stream",
    ETag: `"${createHash("sha1").update(readFileSync(file)).digest("hex")}"`,
  });
  createReadStream(file).pipe(response);
});
new WebSocketServer({ server, path: "/ws", handleProtocols: () => "hil.v1" }).on("connection", (socket) => new Client(socket));
server.listen(PORT, "127.0.0.1", () => console.log(`http://127.0.0.1:${PORT}/`));
