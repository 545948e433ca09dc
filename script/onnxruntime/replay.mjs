// Runs an exported model over a file of calls and prints what it answered, as one JSON array.
//   node script/onnxruntime/replay.mjs MODEL.onnx CALLS.json
// CALLS.json: an array, one object a call: input name -> {"dims": [...], "data": [...]}. A state_K that a call does not
// give is the next_state_K of the call before, zeros in the first. Of each call's answer the states are left out.
import { readFile } from 'node:fs/promises';
import ort from 'onnxruntime-node';

if (process.argv.length !== 4) {
  console.error('usage: node script/onnxruntime/replay.mjs MODEL.onnx CALLS.json');
  process.exit(2);
}
const calls = JSON.parse(await readFile(process.argv[3], 'utf8'));
const session = await ort.InferenceSession.create(process.argv[2], { intraOpNumThreads: 1, interOpNumThreads: 1 });
const types = Object.fromEntries(session.inputMetadata.map((input) => [input.name, input]));

function tensor(name, { dims, data }) {
  const type = types[name]?.type ?? 'float32';
  return new ort.Tensor(type, type === 'int64' ? BigInt64Array.from(data, BigInt) : Float32Array.from(data), dims);
}

const states = {};
const answers = [];
for (const call of calls) {
  const feeds = { ...states };
  for (const [name, value] of Object.entries(call)) feeds[name] = tensor(name, value);
  const batch = call[Object.keys(call)[0]].dims[0];
  for (const { name, shape } of session.inputMetadata)
    if (name.startsWith('state_') && !feeds[name]) feeds[name] = new ort.Tensor('float32', new Float32Array(batch * shape[1]), [batch, shape[1]]);
  const answer = await session.run(feeds);
  const shown = {};
  for (const [name, value] of Object.entries(answer))
    if (name.startsWith('next_')) states[name.slice('next_'.length)] = value;
    else shown[name] = { dims: value.dims, data: Array.from(value.data) };
  answers.push(shown);
}
process.stdout.write(JSON.stringify(answers));
