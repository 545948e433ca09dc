// Recording a dataset from the page, in a real browser against a mock session: chosen, consented, checked, read, interrupted
// by everything that interrupts, and ended.
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
import { GL, launch, openPage, PATIENCE, settled } from "./browser.mjs";
import { startMockSession } from "./mock_session.mjs";

const pictures = process.env.MIEN_SCREENSHOTS ?? "";
if (pictures) mkdirSync(pictures, { recursive: true });

let browser;
const troubles = [];

before(async () => {
  browser = await launch();
});
after(async () => {
  await browser?.close();
});

async function picture(page, name) {
  if (pictures) await page.screenshot({ path: join(pictures, `dataset_${name}.png`), timeout: PATIENCE });
}

const button = (page, name) => page.locator(".recorder").getByRole("button", { name });
const step = (page, name) => settled(page, (wanted) => document.querySelector(".recorder[open]")?.dataset.step === wanted, name, name);
const says = (page, selector, words) => settled(page, ([where, what]) => document.querySelector(where)?.textContent.includes(what), `${selector}: ${words}`, [selector, words]);
const reads = (page, words) => says(page, ".tele-text", words);
const dids = (mock) => mock.session.commands.filter((one) => one.command === "prompts").map((one) => one.do);
const begins = (mock) => mock.session.commands.filter((one) => one.command === "dataset" && one.begin);

/** The countdown is over, and the line is asked for. */
const running = (page) => settled(page, () => document.querySelector(".tele")?.dataset.state === "running", "a line that is asked for");

async function agree(page) {
  await step(page, "consent");
  await page.getByLabel("Recorded by").fill("The lab, Room 12");
  await page.getByLabel("What for").fill("Learning\nhow faces move");
  await page.getByLabel(/I have read this/).check();
  await button(page, "Begin").click();
}

test("the whole way: chosen, consented, checked, read, poor lines again, watched", { timeout: 12 * PATIENCE }, async () => {
  const mock = await startMockSession({ quick: true, microphone: true, phone: true, every: 6 });
  const page = await openPage(browser, mock.url, troubles, { viewport: { width: 1280, height: 800 }, colorScheme: "dark" });
  try {
    mock.session.dataset.faults = { "calm 2": [["mentalis was lost", "nothing moved"], []], enough: [["phone saw no face"], ["phone saw no face"], ["phone saw no face"]] };
    mock.session.voice.level = 0.62;
    mock.session.voice.hearing.blocks = 500;
    mock.session.states.phone = "no_face";
    await settled(page, () => document.querySelectorAll(".links tbody tr").length === 14, "a status");

    // What.
    await page.getByRole("tab", { name: "Takes" }).click();
    await page.getByRole("button", { name: "Record a dataset…" }).click();
    await step(page, "what");
    await says(page, ".script-cards", "Dataset, English");
    await page.getByLabel("Performer", { exact: true }).selectOption("");
    await button(page, "Continue").click();
    await says(page, ".recorder-step:not([hidden]) .recorder-problem:not([hidden])", "Say who performs");
    await page.getByLabel("Name or code of the performer").fill("carla");
    await says(page, ".recorder-note", "Nothing of carla is in “faces” yet: all 8 lines");
    await page.getByLabel("Performer", { exact: true }).selectOption("anna");
    await says(page, ".recorder-note", "anna has 3 lines in “faces” already, in 2 takes.");
    await page.getByLabel("Dataset", { exact: true }).selectOption("");
    await page.getByLabel("Name of the new dataset").fill("../odd");
    await page.getByLabel("Name or code of the performer").fill("carla");
    await page.getByLabel(/By voice/).check();
    await picture(page, "what");
    await button(page, "Continue").click();

    // Consent: not without the tick, and the session's refusal is said where it is read.
    await step(page, "consent");
    assert.match(await page.locator(".recorder-step:not([hidden])").innerText(), /since the session began[\s\S]*beside the other takes on the machine[\s\S]*deleting its file deletes it/);
    await button(page, "Begin").click();
    await says(page, ".recorder-step:not([hidden]) .recorder-problem:not([hidden])", "Say who records this");
    await page.getByLabel("Recorded by").fill("The lab, Room 12");
    await page.getByLabel("What for").fill("Learning\nhow faces move");
    await button(page, "Begin").click();
    await says(page, ".recorder-step:not([hidden]) .recorder-problem:not([hidden])", "Nothing is recorded without consent");
    assert.equal(begins(mock).length, 0, "the session is not even asked");
    await picture(page, "consent_refused");
    await page.getByLabel(/I have read this/).check();
    await page.getByLabel(/the sound of my voice/).check();
    await button(page, "Begin").click();
    await says(page, ".recorder-step:not([hidden]) .recorder-problem:not([hidden])", "not a name for a dataset");
    await button(page, "Back").click();
    await step(page, "what");
    await page.getByLabel("Dataset", { exact: true }).selectOption("faces");
    await button(page, "Continue").click();
    await step(page, "consent");
    assert.equal(await page.getByLabel(/I have read this/).isChecked(), false, "consent is asked for anew");
    assert.equal(await page.getByLabel("Recorded by").inputValue(), "The lab, Room 12");
    await page.getByLabel(/I have read this/).check();
    await page.getByLabel(/the sound of my voice/).check();
    await picture(page, "consent");
    await button(page, "Begin").click();

    // The check before the first block.
    await step(page, "check");
    const { begin } = begins(mock).at(-1);
    assert.deepEqual(begin, { name: "faces", script: "dataset_en", performer: "carla", recorded_by: "The lab, Room 12", purpose: "Learning how faces move", sound: true, video: false, agreed: true, pace: "voice" });
    await says(page, "#recorder-block", "Calm");
    await says(page, ".recorder-step:not([hidden])", "3 lines, under a minute; 8 lines in all");
    const rows = await page.locator(".check-part").first().locator(".check-row").evaluateAll((all) => all.map((row) => [row.dataset.sensor, row.dataset.severity]));
    assert.deepEqual(rows.map(([, severity]) => severity), ["bad", "bad", "bad", "warn"], "the worst first");
    await says(page, ".check-part .check-row[data-sensor=phone]", "sees no face");
    await says(page, ".recorder-step:not([hidden])", "You are heard well.");
    assert.equal(await page.getByRole("meter", { name: "Level of the microphone" }).getAttribute("aria-valuenow"), "62");
    await says(page, ".recorder-head", "recording");
    await picture(page, "check");
    await page.keyboard.press("Escape");
    await step(page, "check");

    // Set aside to see to a sensor, and back.
    await button(page, "Show the page").click();
    await settled(page, () => !document.querySelector(".recorder").open, "the page");
    await picture(page, "aside");
    await page.locator(".record-strip").getByRole("button", { name: "Back to it" }).click();
    await step(page, "check");
    await page.keyboard.press("Enter");

    // The lines.
    await step(page, "lines");
    await settled(page, () => document.querySelector(".tele").dataset.state === "ready", "a countdown");
    await picture(page, "ready");
    await running(page);
    await reads(page, "The lighthouse keeper");
    const text = page.locator(".tele-text");
    assert.deepEqual(await text.evaluate((one) => [one.lang, one.dir]), ["en", "auto"]);
    assert.ok(Number.parseFloat(await text.evaluate((one) => one.style.fontSize)) >= 48, "type to be read from afar");
    assert.match(await page.locator("[aria-live=assertive].hidden-visually").first().textContent(), /Neutral\. Read calmly\. The lighthouse/);
    await picture(page, "line");
    await page.keyboard.press("PageDown");
    await reads(page, "When sunlight strikes");
    await picture(page, "long_line");
    await page.waitForTimeout(500);
    await page.keyboard.press("ArrowRight");
    await reads(page, "Tea, please.");
    await says(page, ".tele-news:not([hidden])", "The last line: mentalis was lost, nothing moved. It is asked for again at the end.");
    await says(page, ".tele-again", "1 to be asked for again");
    await picture(page, "poor");

    // Once more from its beginning, paused, gone on with; the button and the key do the same.
    await page.waitForTimeout(500);
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press(" ");
    await settled(page, () => document.querySelector(".tele").dataset.state === "paused", "a pause");
    await picture(page, "paused");
    await button(page, /^Go on/).first().click();
    await running(page);
    await reads(page, "Tea, please.");

    // A browser that is closed and comes back, and a second one.
    await page.reload();
    await step(page, "lines");
    await reads(page, "Tea, please.");
    const other = await openPage(browser, mock.url, troubles, { viewport: { width: 700, height: 500 } });
    await step(other, "lines");
    await reads(other, "Tea, please.");
    await other.keyboard.press("Enter");
    await step(page, "check");
    await step(other, "check");
    await other.context().close();
    await says(page, "#recorder-block", "Expressions");

    // Faces to make.
    await button(page, /^Begin the block/).click();
    await step(page, "lines");
    await settled(page, () => document.querySelector(".face-view").dataset.second === "target", "a face that makes it");
    await settled(page, () => {
      const [place, label] = [document.querySelector(".tele-window"), document.querySelector(".face-label")].map((one) => one.getBoundingClientRect());
      return place.height > 200 && label.top >= place.top - 1 && label.bottom <= place.bottom;
    }, "faces where they are seen");
    await running(page);
    await reads(page, "Smile as wide as you can");
    assert.ok(await button(page, /^Next/).isDisabled(), "what has its own time goes on by itself");
    await picture(page, "pose");
    await settled(page, () => /^[5-9] of/.test(document.querySelector(".tele-figures span").textContent), "it did");
    await reads(page, "You came!");
    await running(page);
    await picture(page, "pose_and_text");
    await page.keyboard.press("s");
    await step(page, "check");
    await says(page, "#recorder-block", "Emotional");
    await page.keyboard.press(" ");
    await step(page, "lines");
    await running(page);
    await reads(page, "I kept your letters");
    await picture(page, "emotional");
    await page.keyboard.press("Enter");
    await reads(page, "Enough!");
    await running(page);
    await page.waitForTimeout(500);
    await button(page, /^Next/).click();

    // What was poor is asked for again.
    await step(page, "check");
    await says(page, "#recorder-block", "Once more");
    await says(page, ".recorder-note.warn:not([hidden])", "phone saw no face");
    await says(page, ".recorder-step:not([hidden])", "2 lines");
    await picture(page, "once_more");
    await page.keyboard.press("PageDown");
    await step(page, "lines");
    for (const words of ["When sunlight strikes", "Enough!", "Enough!"]) {
      await running(page);
      await reads(page, words);
      await page.waitForTimeout(700);
      await page.keyboard.press("Enter");
    }

    // The end.
    await step(page, "summary");
    await says(page, ".recorder-step:not([hidden])", "6 of 8 lines are recorded well. 2 lines are left, and asked for the next time. carla has 6 lines in “faces” now, in 1 take.");
    await says(page, ".recorder-step:not([hidden])", "faces/carla_1.mien");
    assert.deepEqual(await page.locator(".poor-list li").allInnerTexts(), ["Enough! Not one more word, not one!\nphone saw no face"]);
    await picture(page, "summary");
    const expected = ["begin", "next", "next", "again", "pause", "resume", "next", "begin", "skip", "begin", "next", "next", "begin", "next", "next", "next"];
    assert.deepEqual(dids(mock), expected);
    await page.reload();
    await step(page, "summary");
    await says(page, ".poor-list", "Enough!");
    await button(page, "Watch the take").click();
    await page.locator(".timeline").waitFor({ state: "visible" });
    assert.ok(mock.session.commands.some((one) => one.command === "replay" && one.take === "carla_1.mien" && one.dataset === "faces"));
    await page.reload();
    await settled(page, () => document.querySelectorAll(".links tbody tr").length === 14, "a status");
    assert.equal(await page.locator(".recorder[open]").count(), 0, "what was put away stays away");
  } finally {
    await page.context().close();
    await mock.close();
  }
});

test("what interrupts: a full disk, a broken connection, an end for today, and nonsense", { timeout: 10 * PATIENCE }, async () => {
  const mock = await startMockSession({ every: 12 });
  const page = await openPage(browser, mock.url, troubles, { viewport: { width: 1280, height: 800 }, colorScheme: "light" });
  try {
    await settled(page, () => document.querySelectorAll(".links tbody tr").length === 12, "a status");
    await page.keyboard.press("p");
    await step(page, "what");
    await says(page, ".script-cards", "Dataset, English");
    assert.ok(await page.getByLabel(/By voice/).isDisabled(), "no voice to follow");
    await page.keyboard.press("Escape");
    await settled(page, () => !document.querySelector(".recorder").open, "closed");

    // By keyboard alone.
    await page.keyboard.press("p");
    await step(page, "what");
    await says(page, ".script-cards", "Dataset, English");
    await page.locator(".script-card input:checked").focus();
    await page.keyboard.press("Enter");
    await agree(page);
    await step(page, "check");
    await says(page, ".recorder-step:not([hidden])", "No phone is there");
    await says(page, ".recorder-step:not([hidden])", "This session hears no microphone");
    await picture(page, "check_light");
    await page.keyboard.press("Enter");
    await step(page, "lines");
    await running(page);
    await picture(page, "line_light");

    // An end is asked for twice.
    await button(page, /^End …/).click();
    await says(page, ".recorder-confirm:not([hidden])", "5 lines are left: asked for the next time.");
    await picture(page, "end");
    await page.keyboard.press("Escape");
    await page.locator(".recorder-confirm").waitFor({ state: "hidden" });
    assert.equal(mock.session.dataset.state.over, false);

    // Nonsense within what is read.
    const odd = { type: "status", dataset: { name: 7, lines: "many", over: "no" }, prompts: { state: "running", text: ["x"], target: 5, poor: "all", again: -3, next: 9, number: {}, of: null, language: "e n<", attempt: "x" }, links: [{ sensor: "a", state: 9 }] };
    const long = { type: "status", dataset: { name: "n".repeat(5000), performer: "p".repeat(5000), take: "t".repeat(5000), lines: 1e99, done: -5, over: false, error: null }, recording: { on: true },
      prompts: { state: "running", text: "W".repeat(5000), say: "s".repeat(5000), block: "b".repeat(900), emotion: "e".repeat(900), own_pace: true, language: "en", target: null, poor: ["w".repeat(5000)], again: 1e12, next: { name: "", text: "n ".repeat(5000) }, number: 3, of: 9, progress: 5, left_s: 1e300 } };
    mock.session.silent = true;
    for (const client of mock.session.clients) for (const message of [odd, long]) client.send(JSON.stringify(message));
    await reads(page, "WWWW");
    const size = await page.evaluate(() => ({ wide: document.querySelector(".recorder").scrollWidth, high: document.querySelector(".tele-foot").getBoundingClientRect().bottom, view: [innerWidth, innerHeight], text: document.querySelector(".tele-text").textContent.length }));
    assert.ok(size.wide <= size.view[0] && size.high <= size.view[1] && size.text === 2000, JSON.stringify(size));
    await picture(page, "long");
    await says(page, ".recorder-trouble:not([hidden])", "The connection to the session broke");
    mock.session.silent = false;
    await reads(page, "You came!");
    await page.locator(".recorder-trouble").waitFor({ state: "hidden" });

    mock.session.dataset.fail("anna_3.mien: the disk is full after 214 MB; make room on it");
    await step(page, "summary");
    await says(page, "#recorder-over", "The recording ended early");
    await says(page, ".recorder-error:not([hidden])", "the disk is full after 214 MB");
    await says(page, ".recorder-error:not([hidden])", "What was recorded until then is kept");
    await picture(page, "disk_full");

    // On again, to the end for today.
    await button(page, "Record on").click();
    await step(page, "what");
    await button(page, "Continue").click();
    await agree(page);
    await step(page, "check");
    await button(page, /^End …/).click();
    await button(page, "End the recording").click();
    await step(page, "summary");
    await says(page, ".recorder-step:not([hidden])", "0 of 3 lines are recorded well");
    await button(page, "Close").last().click();
    await settled(page, () => !document.querySelector(".recorder").open, "closed");
  } finally {
    await page.context().close();
    await mock.close();
  }
});

test("on a telephone, and from right to left", { timeout: 6 * PATIENCE }, async () => {
  const mock = await startMockSession({ quick: true, microphone: true, every: 12 });
  const page = await openPage(browser, mock.url, troubles, { viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true, colorScheme: "light" });
  const fits = async (what) => {
    const wide = await page.evaluate(() => [document.querySelector(".recorder"), ...document.querySelectorAll(".recorder-step:not([hidden]), .tele:not([hidden])")].map((one) => one.scrollWidth));
    assert.ok(wide.every((one) => one <= 360), `${what}: ${wide}`);
    await picture(page, `phone_${what}`);
  };
  try {
    await page.getByRole("tab", { name: "Takes" }).tap();
    await page.getByRole("button", { name: "Record a dataset…" }).tap();
    await step(page, "what");
    await says(page, ".script-cards", "Arabic");
    await page.locator(".script-card", { hasText: "Arabic" }).tap();
    await fits("what");
    await button(page, "Continue").tap();
    await step(page, "consent");
    await fits("consent");
    await agree(page);
    await step(page, "check");
    await fits("check");
    await button(page, /^Begin the block/).tap();
    await running(page);
    await reads(page, "النوارس");
    assert.equal(await page.locator(".tele-text").evaluate((one) => getComputedStyle(one).direction), "rtl");
    await fits("line");
    const high = await page.locator(".tele-button").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().height));
    assert.ok(high.every((one) => one >= 48), `${high}`);
    await button(page, /^Next/).tap();
    await step(page, "summary");
    await fits("summary");
  } finally {
    await page.context().close();
    await mock.close();
  }
});

/** A camera that shows a clock, and whoever asks for it gets it. */
const WITH_CAMERA = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"];
const video = (mock) => mock.session.video;
const until = async (holds, what) => {
  for (const end = Date.now() + PATIENCE; !holds(); ) {
    assert.ok(Date.now() < end, what);
    await new Promise((soon) => setTimeout(soon, 50));
  }
};

/** Up to the check of a recording; `agrees`: to video too. */
async function toCheck(page, agrees) {
  await settled(page, () => document.querySelectorAll(".links tbody tr").length === 12, "a status");
  await page.keyboard.press("p");
  await step(page, "what");
  await says(page, ".script-cards", "Dataset, English");
  await page.getByLabel("Performer", { exact: true }).selectOption("anna");
  await button(page, "Continue").click();
  await step(page, "consent");
  const tick = page.getByLabel(/Record my face on video/);
  assert.equal(await tick.isChecked(), false, "nobody is filmed without having asked for it");
  if (agrees) await tick.check();
  await agree(page);
  await step(page, "check");
}

test("a camera is recorded beside the take, by who agreed to it", { timeout: 12 * PATIENCE }, async () => {
  const filming = await launch(...GL, ...WITH_CAMERA);
  const mock = await startMockSession({ quick: true, every: 12 });
  const page = await openPage(filming, mock.url, troubles, { viewport: { width: 1280, height: 900 }, colorScheme: "dark" });
  const playing = () => page.locator(".check-preview").evaluate((one) => !one.hidden && one.srcObject?.active === true && one.srcObject.getAudioTracks().length === 0);
  try {
    await toCheck(page, true);
    assert.equal(begins(mock).at(-1).begin.video, true);
    await until(() => (video(mock).files[0]?.chunks ?? 0) >= 2, "chunks");
    assert.ok(await playing(), "what the camera sees is shown");
    await says(page, ".recorder-step:not([hidden])", "Your face is recorded: anna_3.webm");
    await says(page, ".recorder-film[data-on=true]:not([hidden])", "video");
    await picture(page, "video_check");
    await page.keyboard.press("Enter");
    await step(page, "lines");
    await says(page, ".recorder-film[data-on=true]:not([hidden])", "video");
    await picture(page, "video_line");

    // A chunk is lost: another file with another beginning.
    video(mock).fail("chunks that the browser sent are missing (1); another file begins", true);
    await until(() => (video(mock).files[1]?.chunks ?? 0) >= 1, "another file");
    assert.equal(video(mock).files[1].name, "anna_3_2.webm");

    // A browser that comes back goes on, in another file; a second one does not film by itself.
    await page.reload();
    await step(page, "lines");
    await until(() => (video(mock).files[2]?.chunks ?? 0) >= 1, "it goes on");
    const other = await openPage(filming, mock.url, troubles, { viewport: { width: 700, height: 500 } });
    await step(other, "lines");
    await says(other, ".recorder-film[data-on=true]:not([hidden])", "video");
    await other.context().close();

    // The disk is full: told, and the recording goes on.
    video(mock).fail("The video ended: less than 0.5 GB is left on the disk, which the take needs; make room, then use the camera again.");
    await says(page, ".recorder-film[data-on=false]:not([hidden])", "no video");
    assert.equal(mock.session.dataset.state.over, false);
    await until(() => mock.session.prompts.status().state !== "ready", "a line");
    for (let line = 0; line < 8 && (await page.locator(".recorder").getAttribute("data-step")) === "lines"; ++line) {
      await page.keyboard.press("s");
      await page.waitForTimeout(700);
    }
    await step(page, "check");
    await says(page, ".recorder-step:not([hidden])", "less than 0.5 GB is left");
    await picture(page, "video_full");
    await button(page, "Use this browser's camera").click();
    await until(() => (video(mock).files[3]?.chunks ?? 0) >= 1, "it goes on once more");

    // The end: its last chunk comes, and the camera is let go.
    await button(page, /^End …/).click();
    await button(page, "End the recording").click();
    await step(page, "summary");
    await until(() => video(mock).files[3].over && video(mock).client === null, "its end");
    await settled(page, () => !document.querySelector(".check-preview").srcObject, "the camera is let go");
    assert.equal(video(mock).refused, 0);
    for (const file of video(mock).files) {
      assert.ok(file.over && file.bytes > 2000, JSON.stringify({ ...file, data: 0 }));
      assert.ok(file.ages.every((age, i) => i === 0 || age > file.ages[i - 1]), `${file.ages}`);
    }
    const first = Buffer.concat(video(mock).files[0].data).toString("latin1");
    assert.match(first, /V_VP[89]/);
    assert.doesNotMatch(first, /A_OPUS/, "sound goes its own way");
  } finally {
    await filming.close();
    await mock.close();
  }
});

test("without agreement nobody is filmed, and who refuses the camera records on", { timeout: 8 * PATIENCE }, async () => {
  const refusing = await launch(...GL, "--use-fake-device-for-media-stream");
  const mock = await startMockSession({ quick: true, every: 12 });
  const page = await openPage(refusing, mock.url, troubles, { viewport: { width: 1280, height: 900 }, colorScheme: "light", permissions: [] });
  try {
    await page.evaluate(() => {
      globalThis.asked = 0;
      navigator.mediaDevices.getUserMedia = async () => {
        ++globalThis.asked;
        throw new DOMException("Permission denied", "NotAllowedError");
      };
    });
    await toCheck(page, false);
    assert.equal(begins(mock).at(-1).begin.video, false);
    assert.equal(await page.locator(".recorder-film:not([hidden])").count(), 0);
    assert.equal(await page.getByText("Use this browser's camera").isVisible(), false);
    assert.equal(await page.evaluate(() => globalThis.asked), 0);
    await button(page, /^End …/).click();
    await button(page, "End the recording").click();
    await step(page, "summary");
    await button(page, "Close").last().click();

    await toCheck(page, true);
    await says(page, ".recorder-step:not([hidden])", "The browser refused its camera.");
    await says(page, ".recorder-step:not([hidden])", "The recording goes on without video.");
    assert.equal(await page.evaluate(() => globalThis.asked), 1, "not again and again");
    await until(() => video(mock).client === null, "the session is told");
    await says(page, ".recorder-film[data-on=false]:not([hidden])", "no video");
    await picture(page, "video_refused");
    await page.keyboard.press("Enter");
    await step(page, "lines");
    assert.equal(video(mock).files.length, 0);
  } finally {
    await refusing.close();
    await mock.close();
  }
});

test("nothing was said on the console that should not be", () => {
  assert.deepEqual(troubles, []);
});
