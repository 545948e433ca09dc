// The page in a real browser, against a mock session: the face moves, every button does what it says, files are worn, and it
// holds together in dark, in light, on a phone, by keyboard, without WebGL and without its session.
//
//   npm run build && npm run test:page
//
//   MIEN_CHROMIUM     the browser (/usr/bin/chromium)
//   MIEN_SCREENSHOTS  a folder that keeps what was seen
//   MIEN_PROGRAM      the program that gives the real face; an egg without it
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, openPage, PATIENCE, settled } from "./browser.mjs";
import { startMockSession } from "./mock_session.mjs";
import { sphereHead } from "./sphere_head.mjs";

const pictures = process.env.MIEN_SCREENSHOTS ?? "";
if (pictures) mkdirSync(pictures, { recursive: true });

let browser;
let mock;
const troubles = [];

before(async () => {
  mock = await startMockSession({ quick: true });
  browser = await launch();
});
after(async () => {
  await browser?.close();
  await mock?.close();
});

const open = (options = {}, url = mock.url) => openPage(browser, url, troubles, options);

let common;

/** One page for all tests that need no other: a new one takes a card of software half a minute. */
async function shared() {
  common ??= await open();
  return common;
}

async function picture(page, name) {
  if (pictures) await page.screenshot({ path: join(pictures, `${name}.png`), timeout: PATIENCE });
}

/** The last command of this name that the session got, once it satisfies `check`. */
async function obeyed(name, check = () => true) {
  const deadline = Date.now() + PATIENCE;
  for (;;) {
    const found = mock.session.commands.findLast((command) => command.command === name && check(command));
    if (found) return found;
    if (Date.now() > deadline) assert.fail(`The session was never told: ${name}. It got ${JSON.stringify(mock.session.commands.slice(-4))}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

async function drop(page, name, bytes) {
  await page.evaluate(
    ([file, data]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], file));
      for (const type of ["dragenter", "dragover", "drop"]) {
        window.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
      }
    },
    [name, Buffer.from(bytes).toString("base64")],
  );
}

const tab = (page, name) => page.getByRole("tab", { name });

/** Opens a panel; the tab of one that is open would close it. */
async function go(page, name) {
  if ((await tab(page, name).getAttribute("aria-selected")) !== "true") await tab(page, name).click();
}

const button = (page, name) => page.getByRole("button", { name, exact: true });

test("the face is drawn and moves", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  await settled(page, () => [...document.querySelectorAll(".dot")].filter((dot) => dot.style.transform !== "").length >= 11, "sensors on the face");
  const seen = async () => (await page.locator(".stage-canvas").screenshot({ timeout: PATIENCE })).toString("base64");
  const first = await seen();
  let moved = false;
  for (let i = 0; i < 10 && !moved; ++i) {
    await page.waitForTimeout(700);
    moved = (await seen()) !== first;
  }
  assert.ok(moved, "two pictures of a talking face are the same");
});

test("a lost graphics card is told of, and the face comes back with it", { timeout: 4 * PATIENCE }, async () => {
  const page = await open();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  // An empty canvas compresses to little.
  const bytes = async () => (await page.locator(".stage-canvas").screenshot({ timeout: PATIENCE })).length;
  const before = await bytes();
  await page.evaluate(() => {
    const gl = document.querySelector(".stage-canvas").getContext("webgl2");
    globalThis.card = gl.getExtension("WEBGL_lose_context");
    globalThis.card.loseContext();
  });
  await settled(page, () => document.body.textContent.includes("The graphics card was lost"), "a word on it");
  assert.ok((await bytes()) < before / 2, "a face without a card");
  await page.evaluate(() => globalThis.card.restoreContext());
  let back = false;
  for (let i = 0; i < 20 && !back; ++i) {
    await page.waitForTimeout(500);
    back = (await bytes()) > before / 2;
  }
  assert.ok(back, "no face after the card came back");
  await page.context().close();
});

test("weights: bars, provenance, plot and knobs", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await go(page, "Weights");
  const bar = page.locator(".cell[title=mouthSmile_L]");
  await settled(page, () => document.querySelector(".cell[title=jawOpen]")?.dataset.prov === "m", "a measured jaw");
  assert.equal(await page.locator(".cell").count(), 54);
  const letters = await page.locator(".cell").evaluateAll((cells) => cells.map((cell) => [cell.dataset.prov, cell.querySelector(".letter").textContent]));
  assert.ok(letters.every(([prov, letter]) => prov === letter));
  assert.ok(new Set(letters.map(([prov]) => prov)).size >= 4);
  await settled(page, () => /percent, \w+, confidence/.test(document.querySelector(".cell[title=mouthSmile_L]").getAttribute("aria-label")), "a bar that says its value");
  await page.locator(".cell[title=jawOpen]").click();
  assert.equal(await page.locator(".cell[title=jawOpen]").getAttribute("aria-pressed"), "false");
  for (const shape of ["mouthFunnel", "jawOpen", "browDown_L"]) await page.locator(`.cell[title=${shape}]`).click();
  assert.equal(await page.locator(".plot-key").count(), 5);
  await page.locator(".plot-key").first().click();
  assert.equal(await page.locator(".plot-key").count(), 4);
  assert.ok((await page.locator(".plot canvas").count()) > 0);

  await bar.scrollIntoViewIfNeeded();
  await page.locator(".knobs summary").click();
  await page.getByLabel("Gain", { exact: false }).fill("1.5");
  const gain = await obeyed("shape", (command) => command.gains?.browDown_L === 1.5);
  assert.deepEqual(gain.limits, { browDown_L: [0, 1] });
  await page.getByLabel("Least", { exact: false }).fill("0.2");
  await obeyed("shape", (command) => command.limits?.browDown_L?.[0] === 0.2);
  await page.getByRole("button", { name: "As it was" }).click();
  await obeyed("shape", (command) => command.gains?.browDown_L === 1 && command.limits.browDown_L[0] === 0);
  await picture(page, "weights");
});

test("sensors: numbers, one picked on the face, tapped, bound", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await go(page, "Sensors");
  await settled(page, () => document.querySelectorAll(".links tbody tr").length === 12, "a row a sensor");
  const row = page.locator(".links tr[data-sensor=zygomaticus_lower_L]");
  assert.equal(await row.getAttribute("data-severity"), "warn");
  assert.match(await row.innerText(), /lossy[\s\S]*208[\s\S]*ms[\s\S]*1[2-4] %/);
  const lost = await page.locator(".links tr[data-sensor=mentalis] td:not(.level-column)").allInnerTexts();
  assert.deepEqual([lost[0], ...lost.slice(2, 5)], ["0", "–", "–", "–"], "figures of one that is lost");
  assert.match(await page.locator(".sensors-panel .summary").innerText(), /buccinator R frozen/);
  // A dot on the face opens its sensor; the keyboard does it, since a moving target is hard to click.
  await page.locator(".dot[aria-label^='frontalis L']").focus();
  await page.keyboard.press("Enter");
  await settled(page, () => document.querySelector(".detail h3")?.textContent === "frontalis L", "the sensor's details");
  await page.locator(".links tr[data-sensor=mentalis] button").click();
  assert.match(await page.locator(".detail").innerText(), /Nothing is received any more/);
  await picture(page, "sensor");
  await button(page, "Tap it to bind it").click();
  await obeyed("tap", (command) => command.sensor === "mentalis");
  await page.locator(".tap-banner").waitFor({ state: "visible" });
  await page.locator(".tap-banner").waitFor({ state: "hidden" });
  await settled(page, () => /good/.test(document.querySelector(".links tr[data-sensor=mentalis]").textContent), "a bound sensor");
  await button(page, "Close").first().click();

  // Two send as one sensor: both are shown, and one is chosen.
  await page.locator(".links tr[data-sensor=frontalis_R] button").click();
  const senders = page.locator(".detail .sender");
  await settled(page, () => document.querySelectorAll(".detail .sender").length === 2, "two senders");
  assert.match(await senders.nth(0).innerText(), /udp:\/\/192\.168\.1\.40:5005[\s\S]*heard/);
  assert.match(await senders.nth(1).innerText(), /udp:\/\/192\.168\.1\.66:5005[\s\S]*not heard[\s\S]*behaves as no sensor/);
  await picture(page, "two_senders");
  await senders.nth(1).getByRole("button", { name: "Hear this one" }).click();
  await obeyed("hear", (command) => command.sensor === "frontalis_R" && command.source === "udp://192.168.1.66:5005");
  await settled(page, () => /192\.168\.1\.66/.test(document.querySelector(".detail .sender")?.textContent ?? ""), "the other one is heard");
  await button(page, "Close").first().click();

  await page.locator(".unbound-row select").selectOption("buccinator_R");
  await page.locator(".unbound-row").getByRole("button", { name: "Bind" }).click();
  await obeyed("bind", (command) => command.sensor === "buccinator_R" && command.device.startsWith("5C:CF"));
  await page.locator(".unbound").waitFor({ state: "hidden" });
});

test("who can send: said, narrowed by a choice, and a board paired by a click", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await go(page, "Sensors");
  const network = page.locator(".network");
  await network.scrollIntoViewIfNeeded();
  assert.match(await network.innerText(), /Listening on every interface: wlan0 192\.168\.1\.7, eth0 10\.0\.0\.12, lo 127\.0\.0\.1; anybody there can send/);
  await picture(page, "who_can_send");
  await page.getByLabel("Listen on").selectOption("wlan0");
  await obeyed("listen", (command) => command.only === "wlan0");
  mock.session.network.elsewhere = 1234;
  await settled(page, () => /Listening on wlan0 only; anybody there can send\. 1,234 packets from elsewhere/.test(document.querySelector(".network p").textContent), "what is in force");
  await button(page, "Pair").click();
  await obeyed("pair");
  const card = page.locator(".pairing");
  await card.waitFor({ state: "visible" });
  assert.match(await card.innerText(), /static const uint8_t kMienKey\[33\] = \{1, 0x03, .*\};[\s\S]*mien live --key \/home\/you/);
  assert.match(await card.innerText(), /in force from the next start/);
  await card.getByRole("button", { name: "Copy: The line of firmware" }).click();
  await settled(page, () => document.querySelector(".pairing .button").textContent === "Copied", "a copy");
  await picture(page, "pairing");
  await button(page, "Hide the key").click();
  await card.waitFor({ state: "hidden" });
  assert.doesNotMatch(await page.content(), /kMienKey/);
  await page.getByLabel("Listen on").selectOption("");
  await obeyed("listen", (command) => command.only === "");
});

test("calibration: guided to its scores, compared, undone, re-centred", { timeout: 5 * PATIENCE }, async () => {
  const page = await shared();
  await go(page, "Calibration");
  await page.locator(".version").first().waitFor();
  const versions = await page.locator(".version").count();
  mock.session.holdAt = "anchor";
  await button(page, "With expressions").click();
  await page.locator(".guide:not(.prompts) .guide-running").waitFor({ state: "visible" });
  await settled(page, () => document.querySelectorAll(".steps li").length === 8, "a dot a step");
  await settled(page, () => document.querySelector(".guide:not(.prompts) h2").textContent === "Make this face", "an expression to make");
  assert.ok(/\w/.test(await page.locator(".guide:not(.prompts) .guide-words p").innerText()));
  await settled(page, () => document.querySelector(".face-view").dataset.second === "target", "an example beside the face");
  await picture(page, "guide");
  mock.session.holdAt = "";
  await page.locator(".guide-done").waitFor({ state: "visible" });
  assert.equal(await page.locator(".guide-done .scores li").count(), 4);
  await page.locator(".guide-done").getByRole("button", { name: "Done" }).click();
  await settled(page, (count) => document.querySelectorAll(".version").length === count, "a new version", versions + 1);
  assert.match(await page.locator(".version.in-force strong").innerText(), new RegExp(`^${versions + 1}\\.`));

  const boxes = page.locator(".version input[type=checkbox]");
  for (let i = 0; i < 3; ++i) await boxes.nth(i).check();
  assert.equal(await boxes.nth(0).isChecked(), false, "only two are compared");
  assert.equal(await page.locator(".compare thead th").count(), 3);
  await page.locator(".version summary").first().click();
  await picture(page, "versions");
  await page.getByRole("button", { name: "Use this" }).last().click();
  await obeyed("use_calibration", (command) => command.version === 1);
  await settled(page, () => document.querySelector(".version.in-force strong")?.textContent.startsWith("1."), "version 1 in force");
  const advice = page.locator(".calibration-panel .advice");
  assert.equal(await advice.isVisible(), false);
  mock.session.sigmaDeg = 6.3;
  await advice.waitFor({ state: "visible" });
  assert.match(await page.locator(".calibration-panel .summary").innerText(), /^Calibrated .* ago, rotations known to 6\.3°\.$/);
  assert.equal(await page.locator(".action-bar .advised").count(), 1);
  await page.locator(".calibration-panel").getByRole("button", { name: "Re-centre" }).click();
  await obeyed("recentre");
  await settled(page, () => document.querySelector(".version.in-force strong")?.textContent.includes("Re-centred"), "the re-centred version");
  await advice.waitFor({ state: "hidden" });
  assert.match(await page.locator(".calibration-panel .summary").innerText(), /^Calibrated .*, re-centred .*, rotations known to 2\.0°\.$/);
  assert.equal(await page.locator(".action-bar .advised").count(), 0);

  mock.session.holdAt = "neutral";
  await page.keyboard.press("c");
  await page.locator(".guide:not(.prompts) .guide-running").waitFor({ state: "visible" });
  await page.keyboard.press("Escape");
  await obeyed("cancel_calibration");
  mock.session.holdAt = "";
  await page.locator(".guide:not(.prompts)").waitFor({ state: "hidden" });
});

test("takes: recorded, replayed beside the truth, moved in time, left", { timeout: 5 * PATIENCE }, async () => {
  const page = await shared();
  await go(page, "Takes");
  await page.getByLabel("Name of the take").fill("my take");
  await page.locator(".takes-panel .record").click();
  assert.equal((await obeyed("record", (command) => command.on)).name, "my take");
  await settled(page, () => document.querySelector(".chip").textContent === "recording", "a sign that it records");
  await button(page, "Look again").click();
  const growing = page.locator(".take", { hasText: "my take" });
  await growing.waitFor();
  assert.match(await growing.innerText(), /being recorded/);
  assert.doesNotMatch(await growing.innerText(), /\d:\d\d|MB/);
  assert.ok(await growing.getByRole("button").isDisabled(), "it cannot be played yet");
  await picture(page, "growing_take");
  await page.getByRole("button", { name: "Stop recording" }).click();
  await obeyed("record", (command) => command.on === false);
  await page.locator(".take", { hasText: /my take.*MB/ }).waitFor();
  assert.ok(await growing.getByRole("button").isEnabled());

  await page.getByRole("button", { name: "Play reading_aloud.mien" }).click();
  await page.locator(".timeline").waitFor({ state: "visible" });
  await settled(page, () => document.querySelector(".face-view").dataset.second === "truth", "two faces");
  await settled(page, () => /mm of skin/.test(document.querySelector(".difference").textContent), "the error");
  // The devices have no part in it: neither their state nor what to do about them is shown on the face.
  await settled(page, () => [...document.querySelectorAll(".dot")].every((dot) => dot.querySelector(".dot-mark").textContent === "" && dot.dataset.state === "replayed"), "plain dots");
  mock.session.allProvenance = "n";
  await page.locator(".standing", { hasText: "at this time of the take" }).waitFor();
  mock.session.allProvenance = null;
  await page.keyboard.press(" ");
  await obeyed("replay", (command) => command.paused === true);
  await page.getByRole("button", { name: "Play", exact: true }).first().waitFor();
  await page.getByLabel("Time in the take").fill("10");
  await obeyed("replay", (command) => command.seek === 10);
  await settled(page, () => document.querySelector(".timeline .mono").textContent === "0:10", "the new time");
  await picture(page, "replay");
  await page.keyboard.press("t");
  await settled(page, () => document.querySelector(".face-view").dataset.second === "none", "one face");
  await page.keyboard.press("t");
  await button(page, "Leave replay").click();
  await page.locator(".timeline").waitFor({ state: "hidden" });
  await settled(page, () => document.querySelector(".dot[data-state=good]") !== null, "the devices again");
});

test("output: receivers on, off, added, removed; smoothing; refusals are said", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await go(page, "Output");
  const vmc = page.getByRole("switch", { name: /vmc/ });
  await vmc.click();
  await obeyed("sink", (command) => command.sink === 2 && command.on === true);
  await settled(page, () => document.querySelectorAll(".switch")[1].getAttribute("aria-checked") === "true", "a switch that is on");
  const add = page.getByLabel("Address of a new receiver");
  await add.fill("nonsense");
  await page.keyboard.press("Enter");
  await page.locator(".notice", { hasText: "no address of a sink" }).waitFor();
  await add.fill("vrchat://127.0.0.1:9000");
  await page.getByRole("button", { name: "Add" }).click();
  await page.getByRole("button", { name: "Remove vrchat://127.0.0.1:9000" }).click();
  await obeyed("sink", (command) => command.remove === true && command.sink === 4);
  await page.getByLabel("Smoothing").fill("0.6");
  await obeyed("shape", (command) => command.smoothing === 0.6);
  await page.getByLabel("Blinks a minute").fill("20");
  await obeyed("shape", (command) => command.blinks_per_min === 20);
  const learning = page.getByRole("switch", { name: "Learn the face at rest" });
  assert.equal(await learning.getAttribute("aria-checked"), "false");
  await learning.click();
  await obeyed("shape", (command) => command.resting === true);
  await settled(page, () => document.querySelector("[aria-label='Learn the face at rest']").getAttribute("aria-checked") === "true", "a face that is learnt");
  await page.getByRole("switch", { name: "Obey the constraints" }).click();
  await obeyed("shape", (command) => command.constraints === true);
  await page.getByRole("switch", { name: "Lids follow the eyes" }).click();
  await obeyed("shape", (command) => command.lids_follow_eyes === false);
  assert.match(await page.locator(".output-panel").innerText(), /Somebody speaks. 37 % of all frames have shapes from it. Sound lags behind the face by 35 ms/);
  await page.getByRole("switch", { name: "Hear the voice" }).click();
  await obeyed("shape", (command) => command.merge?.audio === false);
  await page.locator(".output-panel", { hasText: "Sound is off" }).waitFor();
  await page.getByRole("button", { name: "Undo the shaping of jawOpen" }).click();
  await obeyed("shape", (command) => command.gains?.jawOpen === 1);
  assert.match(await page.locator(".output-panel").innerText(), /99 % within \d/);
  await picture(page, "output");
});

test("faces are worn: .glb of other names, .vrm, and back; what is none is refused", { timeout: 5 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  await drop(page, "friend.glb", sphereHead({ names: "pascal", scale: 100 }));
  await page.locator(".notice", { hasText: "friend.glb: 53 of 53 shapes" }).waitFor();
  await picture(page, "worn_glb");
  await drop(page, "hero.vrm", sphereHead({ names: "pascal", vrm: true }));
  await page.locator(".notice", { hasText: "hero.vrm: 53 of 53 shapes" }).waitFor();
  await settled(page, () => document.querySelectorAll(".dot:not([data-seen=none])").length >= 11, "sensors on the worn face");
  await drop(page, "head.fbx", Buffer.from("FBX"));
  await page.locator(".notice", { hasText: "not a .glb or .vrm" }).waitFor();
  await drop(page, "broken.glb", Buffer.alloc(4000));
  await page.locator(".notice", { hasText: "not a glTF binary" }).waitFor();
  await page.getByRole("button", { name: "View" }).click();
  await page.getByRole("button", { name: "The session's face again" }).click();
  await page.getByRole("button", { name: "View" }).click();
  await page.getByRole("button", { name: "The session's face again" }).waitFor({ state: "hidden" });
  await page.getByRole("button", { name: /Camera to the front/ }).click();
});

test("the keyboard reaches everything", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.querySelectorAll(".links tbody tr").length === 12, "a status");
  for (const [key, name] of [["2", "Sensors"], ["3", "Calibration"], ["4", "Takes"], ["5", "Output"], ["1", "Weights"]]) {
    await page.keyboard.press(key);
    await settled(page, (label) => document.querySelector("[role=tab][aria-selected=true]")?.textContent === label, name, name);
  }
  await page.keyboard.press("1");
  assert.equal(await page.locator("html").getAttribute("data-panel"), "closed");
  await page.keyboard.press("1");
  await page.keyboard.press("?");
  await page.locator("dialog.help[open]").waitFor();
  await picture(page, "help");
  await page.keyboard.press("Escape");
  await page.locator("dialog.help[open]").waitFor({ state: "detached" });
  await page.keyboard.press("f");
  assert.equal(await page.locator("html").getAttribute("data-bare"), "true");
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("html").getAttribute("data-bare"), "false");
  await page.keyboard.press("d");
  await page.locator(".dots").waitFor({ state: "hidden" });
  await page.keyboard.press("d");
  for (const key of ["h", "h", "v", "ArrowLeft", "ArrowUp"]) await page.keyboard.press(key);
  const before = mock.session.commands.length;
  await page.keyboard.press("r");
  await obeyed("record", (command) => command.on === true && mock.session.commands.indexOf(command) >= before);
  await page.keyboard.press("r");
  await obeyed("record", (command) => command.on === false && mock.session.commands.indexOf(command) >= before);
  await page.keyboard.press(" ");
  await obeyed("recentre", (command) => mock.session.commands.indexOf(command) >= before);
  // Letters typed into a field are letters.
  await page.keyboard.press("4");
  const told = mock.session.commands.length;
  await page.getByLabel("Name of the take").fill("");
  await page.getByLabel("Name of the take").pressSequentially("rc 1?");
  assert.equal(await page.getByLabel("Name of the take").inputValue(), "rc 1?");
  assert.ok(!mock.session.commands.slice(told).some((command) => ["record", "calibrate", "recentre"].includes(command.command)));
});

test("a face that nothing measures says so", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  try {
    mock.session.allProvenance = "h";
    await page.locator(".standing", { hasText: "Held" }).waitFor();
    await picture(page, "held");
    mock.session.allProvenance = "n";
    await page.locator(".standing", { hasText: "Neutral" }).waitFor();
  } finally {
    mock.session.allProvenance = null;
  }
  await page.locator(".standing").waitFor({ state: "hidden" });
});

test("what is said of late packets holds: the newest takes the older's place", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  const held = "holding frames 40 ms: packets arrive late";
  mock.session.holdMs = 40;
  mock.session.event("frames_held", held);
  await page.locator(".notice", { hasText: held }).waitFor();
  mock.session.event("frames_punctual", "packets arrive in time again: frames are not held any more");
  await page.locator(".notice", { hasText: "in time again" }).waitFor();
  assert.equal(await page.locator(".notice", { hasText: held }).count(), 0);
  mock.session.event("frames_held", held);
  await page.locator(".notice", { hasText: held }).waitFor();
  assert.equal(await page.locator(".notice", { hasText: "in time again" }).count(), 0);
  await settled(page, () => document.querySelector(".latency b.gap:not([hidden])")?.textContent === "+ 40 ms held", "the hold beside the latency");
  await picture(page, "held_frames");
  mock.session.holdMs = 0;
});

test("a lost connection is said, and comes back by itself", { timeout: 4 * PATIENCE }, async () => {
  const own = await startMockSession({ quick: true, token: "secret" });
  const page = await open({}, own.url);
  await settled(page, () => document.documentElement.dataset.standing === "live", "the token is passed on");
  own.session.silent = true;
  await page.locator(".standing", { hasText: "Nothing is received" }).waitFor();
  own.session.silent = false;
  await page.locator(".standing").waitFor({ state: "hidden" });
  await own.close();
  await page.locator(".standing", { hasText: "Connection lost" }).waitFor();
  await picture(page, "lost");
  const again = await startMockSession({ quick: true, token: "secret", port: own.port });
  await settled(page, () => document.documentElement.dataset.standing === "live", "the connection again");
  await again.close();
  const refusing = await startMockSession({ quick: true, token: "another", port: own.port });
  await page.locator(".standing", { hasText: "token" }).waitFor();
  await page.context().close();
  const stranger = await open({}, refusing.url.replace("another", "wrong"));
  await stranger.locator(".standing", { hasText: "refuses this page" }).waitFor();
  // Through its further tries too.
  for (let i = 0; i < 20; ++i) {
    assert.ok(await stranger.locator(".face-coming").isHidden(), "no face is promised to a page that is refused");
    await stranger.waitForTimeout(100);
  }
  await picture(stranger, "refused");
  await refusing.close();
  await stranger.context().close();
});

test("nonsense from the session is survived", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  for (const nonsense of ["", "{", "null", '{"type":"frame"}', '{"type":"frame","weights":{}}', '{"type":"status"}', '{"type":"hello"}', '{"type":"status","links":[{"sensor":7}],"sinks":"x"}', '{"type":"event"}', '{"type":"reply"}']) {
    for (const client of mock.session.clients) client.send(nonsense);
  }
  await page.waitForTimeout(500);
  await settled(page, () => document.documentElement.dataset.standing === "live" && document.querySelectorAll(".links tbody tr").length === 12, "all well again");
});

test("without WebGL the weights are still there", { timeout: 4 * PATIENCE }, async () => {
  const blind = await launch("--disable-gpu", "--disable-3d-apis", "--disable-webgl");
  const page = await (await blind.newContext({ viewport: { width: 1000, height: 640 } })).newPage();
  page.on("pageerror", (error) => troubles.push(String(error.stack)));
  await page.goto(mock.url);
  await page.locator(".no-webgl").waitFor({ timeout: PATIENCE });
  await settled(page, () => document.querySelector(".cell[title=jawOpen]")?.dataset.prov === "m", "weights");
  await picture(page, "no_webgl");
  await blind.close();
});

test("dark, light and phone", { timeout: 6 * PATIENCE }, async () => {
  const paper = (page) => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await open({ colorScheme: "dark", viewport: { width: 1280, height: 800 } });
  await settled(dark, () => document.documentElement.dataset.standing === "live", "a living face");
  const night = await paper(dark);
  await picture(dark, "dark");
  await dark.getByRole("button", { name: /^Colours/ }).click();
  assert.notEqual(await paper(dark), night, "the switch makes it light");
  await dark.context().close();
  const light = await open({ colorScheme: "light", viewport: { width: 1280, height: 800 } });
  await settled(light, () => document.documentElement.dataset.standing === "live", "a living face");
  assert.notEqual(await paper(light), night);
  await picture(light, "light");
  await light.context().close();

  const phone = await open({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await settled(phone, () => document.documentElement.dataset.standing === "live", "a living face");
  const size = await phone.evaluate(() => ({ wide: document.documentElement.scrollWidth, panel: document.querySelector(".dock-body").scrollWidth, view: innerWidth }));
  assert.ok(size.wide <= size.view && size.panel <= size.view, JSON.stringify(size));
  for (const name of ["Sensors", "Calibration", "Takes", "Output", "Weights"]) {
    if ((await tab(phone, name).getAttribute("aria-selected")) !== "true") await tab(phone, name).tap();
    const wide = await phone.evaluate(() => document.querySelector(".dock-body").scrollWidth);
    assert.ok(wide <= 390, `${name} is ${wide} wide`);
  }
  const bar = await phone.locator(".action-bar").boundingBox();
  assert.ok(bar.x >= 0 && bar.x + bar.width <= 390, JSON.stringify(bar));
  await picture(phone, "phone");
  await phone.context().close();
});

test("glasses with their sensors, and poses to make", { timeout: 6 * PATIENCE }, async () => {
  const glasses = await startMockSession({ eyewear: true, prompts: true });
  const page = await open({ viewport: { width: 1280, height: 800 } }, glasses.url);
  try {
    await settled(page, () => document.querySelector(".prompts:not([hidden]) h2")?.textContent === "neutral", "the first pose");
    await settled(page, () => [...document.querySelectorAll(".dot.worn")].filter((dot) => dot.style.transform !== "").length === 20, "sensors on the glasses");
    assert.equal(await page.locator(".dot:not(.worn)").count(), 1, "and the one at the ear on its skin");
    assert.equal(await page.locator(".dot.worn[data-severity=bad]").count(), 1);
    await settled(page, () => document.querySelector(".face-view").dataset.second === "target", "a face to follow");
    assert.equal(await page.locator(".next-face").innerText(), "Next: brows up");
    await picture(page, "prompts");

    await button(page, "Pause").click();
    await settled(page, () => document.querySelector(".prompts h2").textContent === "Paused", "a pause");
    await page.keyboard.press(" ");
    await settled(page, () => document.querySelector(".prompts h2").textContent === "Get ready", "on again, by the space bar");
    await button(page, "Skip").click();
    await settled(page, () => /^[2-5] of 5/.test(document.querySelector(".prompt-figures span").textContent), "the next");

    await go(page, "Sensors");
    await settled(page, () => getComputedStyle(document.querySelector("tr[data-sensor=brow_inner_R] .level")).display !== "none", "light levels");
    assert.equal(await page.locator(".links.without-level").count(), 0);
    glasses.session.prompts.at = 99;
    await settled(page, () => document.querySelector(".prompts").hidden && document.querySelector(".face-view").dataset.second === "none", "the end of it");
    await picture(page, "glasses");
    assert.deepEqual(glasses.session.commands.filter((one) => one.command === "prompts").map((one) => one.do), ["pause", "resume", "skip"]);
  } finally {
    await page.context().close();
    await glasses.close();
  }
});

test("memory stays flat", { timeout: 4 * PATIENCE }, async () => {
  const page = await shared();
  await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
  const elements = () => page.evaluate(() => document.querySelectorAll("*").length);
  const first = await elements();
  // Ten minutes of frames and statuses at once.
  for (let i = 0; i < 100; ++i) {
    for (let k = 0; k < 24; ++k) mock.session.say(mock.session.status());
    for (let k = 0; k < 60; ++k) mock.session.tick();
    mock.session.event("note", `Note ${i}`);
    await page.waitForTimeout(10);
  }
  await page.waitForTimeout(1000);
  const last = await elements();
  // The log of events is the one thing that grew: to its limit.
  assert.ok(last - first < 150, `${first} elements became ${last}`);
});

test("nothing was said on the console that should not be", () => {
  assert.deepEqual(troubles, []);
});
