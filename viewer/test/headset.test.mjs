// A headset's cameras on the page, in a real browser against a mock session: where they are shown, and who is shown what they see.
//
//   npm run build && npm run test:page
//
//   MIEN_CHROMIUM     the browser (/usr/bin/chromium)
//   MIEN_SCREENSHOTS  a folder that keeps what was seen
//   MIEN_PROGRAM      the program that gives the real face; an egg without it
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { launch, openPage, PATIENCE, settled } from "./browser.mjs";
import { startMockSession } from "./mock_session.mjs";

const pictures = process.env.MIEN_SCREENSHOTS ?? "";
if (pictures) mkdirSync(pictures, { recursive: true });

async function picture(page, name) {
  if (pictures) await page.screenshot({ path: join(pictures, `${name}.png`), timeout: PATIENCE });
}

const troubles = [];

test("a headset: its cameras beside the face, their pictures only where they are asked for", { timeout: 4 * PATIENCE }, async () => {
  const headset = await startMockSession({ headset: true, quick: true, every: 12 });
  const browser = await launch();
  const page = await openPage(browser, headset.url, troubles, { viewport: { width: 1280, height: 800 } });
  const button = (name) => page.getByRole("button", { name, exact: true });
  const view = (name) => page.locator(".camera-view", { hasText: name });
  try {
    await settled(page, () => document.documentElement.dataset.standing === "live", "a living face");
    await settled(page, () => [...document.querySelectorAll(".camera-view")].filter((one) => one.style.transform !== "").length === 4, "four cameras");
    assert.equal(await page.locator(".dot").count(), 0, "cameras sit on no skin");
    assert.equal(await page.locator(".camera-view canvas:not([hidden])").count(), 0, "nobody asked for pictures");
    assert.equal(headset.session.cameras.sent, 0);
    assert.equal(await view("mouth R").getAttribute("data-severity"), "bad");
    assert.equal(await view("eye L").getAttribute("data-severity"), "good");
    // Beside the face, as one sees the performer: their left on the right, eyes above the mouth.
    const box = async (name) => await view(name).boundingBox();
    assert.ok((await box("eye L")).x > (await box("eye R")).x + 100);
    assert.ok((await box("mouth L")).y > (await box("eye L")).y + 30);
    await picture(page, "headset");

    // Points to look at.
    await page.getByRole("tab", { name: "Calibration" }).click();
    headset.session.holdAt = "gaze";
    await button("Where I look").click();
    await settled(page, () => document.querySelector(".guide:not(.prompts) h2").textContent === "Look there", "a point to look at");
    await settled(page, () => document.querySelector(".look:not([hidden]) .look-words")?.textContent === "ahead", "its direction");
    await picture(page, "look");
    headset.session.holdAt = "";
    await settled(page, () => document.querySelector(".look-words")?.textContent === "15° left", "the next one");
    assert.ok(Number(await page.locator(".look-point").getAttribute("cx")) < 0, "left is left for who looks");
    await page.locator(".guide-done").waitFor({ state: "visible" });
    await page.locator(".guide-done").getByRole("button", { name: "Done" }).click();

    await page.getByRole("tab", { name: "Sensors" }).click();
    await button("Show pictures").click();
    await settled(page, () => document.querySelectorAll(".camera-view[data-pictured=true]").length === 4, "four pictures");
    const levels = await view("eye L").locator("canvas").evaluate((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      const grey = [...data].filter((_, i) => i % 4 === 0);
      return { least: Math.min(...grey), most: Math.max(...grey), alpha: data[3] };
    });
    assert.ok(levels.least < 40 && levels.most > 215 && levels.alpha === 255, JSON.stringify(levels));
    const brightness = (name) => view(name).locator("canvas").evaluate((canvas) => Number(canvas.style.opacity));
    assert.ok((await brightness("mouth R")) < (await brightness("mouth L")) - 0.2, "what is little known is dim");
    assert.equal(await page.locator(".headset-facts dd").nth(1).innerText(), "measured");
    headset.session.mouthIsHeard = true;
    await settled(page, () => document.querySelectorAll(".headset-facts dd")[1].textContent === "from sound", "a mouth that is heard");
    assert.equal(await page.locator(".headset-facts dd").first().innerText(), "measured");
    const open = await page.locator(".headset-facts [role=meter]").first().getAttribute("aria-valuenow");
    assert.ok(Number(open) >= 0 && Number(open) <= 100, open);
    await settled(page, () => Number(document.querySelector(".headset-facts [role=meter]").getAttribute("aria-valuenow")) > 50, "an open eye");
    const bar = await page.locator(".headset-facts .level-run").first().evaluate((run) => {
      return { colour: getComputedStyle(run).backgroundColor, width: run.getBoundingClientRect().width };
    });
    assert.ok(!/, 0\)$|transparent/.test(bar.colour) && bar.width > 20, JSON.stringify(bar));
    await picture(page, "headset_pictures");

    headset.session.states.eye_L = "lost";
    await settled(page, () => document.querySelectorAll(".camera-view[data-pictured=true]").length === 3, "no picture of a camera that is lost");
    delete headset.session.states.eye_L;
    await settled(page, () => document.querySelectorAll(".camera-view[data-pictured=true]").length === 4, "it is back");

    // While a take is played what the cameras see is nothing of that face.
    headset.session.obey({ command: "replay", take: "reading_aloud.mien" });
    await settled(page, () => document.querySelectorAll(".camera-view[data-pictured=true]").length === 0, "no pictures beside a take");
    headset.session.obey({ command: "replay", stop: true });
    await settled(page, () => document.querySelectorAll(".camera-view[data-pictured=true]").length === 4, "pictures again");

    await button("Hide pictures").click();
    await settled(page, () => document.querySelectorAll(".camera-view canvas:not([hidden])").length === 0, "no pictures");
    const sent = headset.session.cameras.sent;
    await page.waitForTimeout(500);
    assert.equal(headset.session.cameras.sent, sent, "nor are any sent");
    const blank = await view("eye L").locator("canvas").evaluate((canvas) => canvas.getContext("2d").getImageData(0, 0, 96, 96).data.every((value) => value === 0));
    assert.ok(blank, "and none is left behind");
    await view("mouth L").click();
    await settled(page, () => document.querySelector(".detail:not([hidden]) h3")?.textContent === "mouth L", "the camera's numbers");
    // Which part of its pictures is seen is changed by buttons, each from what the session says that it is.
    const seen = () => headset.session.views.mouth_L;
    const pressed = async (name, words) => {
      await button(name).click();
      await settled(page, (text) => document.querySelector(".camera-buttons p")?.textContent.includes(text), name, words);
      return seen();
    };
    assert.equal((await pressed("Turn", "turned 90°")).turn_deg, 90);
    assert.equal((await pressed("Mirror", "mirrored")).mirror, true);
    assert.deepEqual((await pressed("Closer", "75 % × 75 %")).crop, [0.133, 0.213, 0.754, 0.754]);
    await button("Look more to the right").click();
    await button("Save to rig").click();
    await settled(page, () => [...document.querySelectorAll("[role=status], [role=alert]")].some((one) => one.textContent.includes("Saved to rigs/headset.toml")), "saved");
    // Turned and mirrored, right of what is shown is up or down in the picture.
    assert.deepEqual(seen().crop.map((edge, i) => Math.round(1000 * (edge - [0.133, 0.213, 0.754, 0.754][i]))).map(Math.abs), [0, 20, 0, 0]);
    assert.equal(headset.session.saved, 1);
    await picture(page, "headset_view");
    // And it is bound by covering its lens.
    await button("Cover it to bind it").click();
    await settled(page, () => document.querySelector(".tap-banner:not([hidden])")?.textContent.includes("Cover this camera's lens"), "asked for a finger");
    await settled(page, () => document.querySelector(".tap-banner")?.hidden === true, "bound");
    assert.equal(headset.session.devices.mouth_L, "02:4D:49:48:53:7F/0");
    headset.session.cover = { sensor: null, trouble: "two lenses are covered at once; ask again, and cover one alone" };
    await settled(page, () => document.querySelector(".detail p")?.textContent.includes("two lenses are covered"), "what was in the way");
    assert.deepEqual(headset.session.commands.filter((one) => one.command === "pictures").map((one) => one.on), [true, false]);
    assert.deepEqual(troubles, []);
  } finally {
    await browser.close();
    await headset.close();
  }
});
