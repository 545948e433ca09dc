// Times exported models in ONNX Runtime on one thread and prints one JSON object.
//   node script/onnxruntime/time.mjs JOB.json
// JOB.json: {"rounds": R, "round_s": S, "graphs": [{"name", "model", "echo", "steps", "inputs"}]}; `model` and `echo` are files
// (`echo` has the same inputs and gives them back), `steps` is how many steps one run does, `inputs` as in replay.mjs.
// The rounds go through all graphs in turn, so that a busy neighbour slows them alike. A graph's time is the median of its
// rounds' medians. What calling from JavaScript costs (a turn of the event loop, tensors in and out) is the echo's time, and is
// taken off: step_s = (run_s - echo_s) / steps; best_step_s: the same of the quickest rounds. Outputs go into buffers that are
// made once, as a program would that wants speed.
import { readFile } from 'node:fs/promises';
import ort from 'onnxruntime-node';

if (process.argv.length !== 3) {
  console.error('usage: node script/onnxruntime/time.mjs JOB.json');
  process.exit(2);
}
const job = JSON.parse(await readFile(process.argv[2], 'utf8'));
const options = { intraOpNumThreads: 1, interOpNumThreads: 1, executionMode: 'sequential', graphOptimizationLevel: 'all' };

function tensors(session, inputs) {
  const made = {};
  for (const { name, type } of session.inputMetadata) {
    const { dims, data } = inputs[name];
    made[name] = new ort.Tensor(type, type === 'int64' ? BigInt64Array.from(data, BigInt) : Float32Array.from(data), dims);
  }
  return made;
}

async function load(file, inputs) {
  const session = await ort.InferenceSession.create(file, options);
  const feeds = tensors(session, inputs);
  const outputs = { ...(await session.run(feeds)) };
  return { session, feeds, outputs, medians: [] };
}

function median(values) {
  const sorted = Float64Array.from(values).sort();
  return sorted[Math.floor(sorted.length / 2)];
}

async function round({ session, feeds, outputs, medians }, seconds) {
  const times = [];
  const until = performance.now() + 1e3 * seconds;
  // Five at least; the first finds cold caches and is left out.
  for (let i = 0; i < 6 || performance.now() < until; ++i) {
    const from = performance.now();
    await session.run(feeds, outputs);
    if (i > 0) times.push(1e-3 * (performance.now() - from));
  }
  medians.push(median(times));
}

const graphs = [];
for (const graph of job.graphs)
  graphs.push({ ...graph, run: await load(graph.model, graph.inputs), idle: await load(graph.echo, graph.inputs) });
for (let r = 0; r < job.rounds; ++r)
  for (const { run, idle } of graphs) {
    await round(run, job.round_s);
    await round(idle, job.round_s / 4);
  }

const told = graphs.map(({ name, steps, run, idle }) => {
  const [run_s, echo_s] = [median(run.medians), median(idle.medians)];
  const answer = Object.entries(run.outputs).find(([output]) => !output.startsWith('next_'))[1];
  return {
    name,
    steps,
    run_s,
    echo_s,
    step_s: (run_s - echo_s) / steps,
    best_step_s: (Math.min(...run.medians) - Math.min(...idle.medians)) / steps,
    answer: Array.from(answer.data),
  };
});
process.stdout.write(JSON.stringify({ onnxruntime: ort.env.versions.node, node: process.version, graphs: told }));
