import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { entrances, reachText } = await load("panels/network.ts");

const NETWORK = {
  open: ["udp://0.0.0.0:5005"], only: "", elsewhere: 0, sealed: false, refused: 0,
  interfaces: [
    { name: "wlan0", address: "192.168.1.7", loopback: false }, { name: "wlan0", address: "2001:db8::7", loopback: false },
    { name: "lo", address: "127.0.0.1", loopback: true },
  ],
};

test("who can send is said as it is", () => {
  assert.equal(reachText(NETWORK, NETWORK.open), "Listening on every interface: wlan0 192.168.1.7, wlan0 2001:db8::7, lo 127.0.0.1; anybody there can send.");
  assert.equal(reachText({ ...NETWORK, only: "wlan0", elsewhere: 1200 }, NETWORK.open), "Listening on wlan0 only; anybody there can send. 1,200 packets from elsewhere were refused.");
  assert.match(reachText({ ...NETWORK, sealed: true, refused: 3 }, NETWORK.open), /; only boards with the key are received\. 3 packets without it were refused\.$/);
  const own = { ...NETWORK, open: [] };
  const reached = "Whoever reaches an address that it listens on can send.";
  assert.equal(reachText(own, ["udp://192.168.1.7:5005"]), reached);
  assert.equal(reachText(own, ["udp://127.0.0.1:5005", "udp://192.168.1.7:5005"]), reached);
  assert.equal(reachText(own, ["udp://127.0.0.1.example.org:5005"]), reached);
  for (const here of ["udp://127.0.0.1:5005", "udp://[::1]:5005", "serial:/dev/ttyUSB0?baud=250000"]) {
    assert.equal(reachText(own, [here]), "Only what is on this machine, or plugged into it, can send.");
  }
  assert.equal(reachText({ ...own, sealed: true }, ["udp://127.0.0.1:5005"]), "Only boards with the key are received.");
});

test("an interface is one choice, whatever its addresses; what is in force can always be seen", () => {
  assert.deepEqual(entrances(NETWORK), [["", "every interface"], ["wlan0", "wlan0 192.168.1.7, 2001:db8::7"], ["lo", "lo 127.0.0.1"]]);
  assert.deepEqual(entrances({ ...NETWORK, only: "10.0.0.3" }).at(-1), ["10.0.0.3", "10.0.0.3"]);
});
