// What sinks send, read by libraries that are not ours; each message is printed as one line of JSON.
//   node tests/sink/other_readers.mjs osc MESSAGES       listens on a free UDP port, prints it, then MESSAGES OSC messages
//   node tests/sink/other_readers.mjs ws URL MESSAGES    connects, and prints that many messages
import dgram from 'node:dgram';
import { createRequire } from 'node:module';

const require = createRequire(new URL('../../script/npm/package.json', import.meta.url));
const [kind, ...rest] = process.argv.slice(2);
setTimeout(() => process.exit(3), 30_000).unref();

let left = Number(rest.at(-1));
function print(message) {
  if (left <= 0) return;
  console.log(JSON.stringify(message));
  left -= 1;
  if (left === 0) process.exit(0);
}

if (kind === 'osc') {
  const OSC = require('osc-js');
  const socket = dgram.createSocket('udp4');
  socket.on('message', (datagram) => {
    const bundle = new OSC.Bundle();
    bundle.unpack(new DataView(datagram.buffer, datagram.byteOffset, datagram.byteLength));
    for (const { address, types, args } of bundle.bundleElements) print({ bytes: datagram.byteLength, address, types, args });
  });
  socket.bind(0, '127.0.0.1', () => console.log(socket.address().port));
} else if (kind === 'ws') {
  const { WebSocket } = require('ws');
  const socket = new WebSocket(rest[0]);
  socket.on('message', (data) => print(JSON.parse(data.toString())));
  socket.on('error', () => process.exit(4));
} else {
  console.error('usage: node tests/sink/other_readers.mjs osc MESSAGES | ws URL MESSAGES');
  process.exit(2);
}
