// Pictures of the skin in a real browser: asked for, with the token, by the look that shows them.
import assert from "node:assert/strict";
import { test } from "node:test";
import { launch, openPage, PATIENCE, settled } from "./browser.mjs";
import { startMockSession } from "./mock_session.mjs";
import { sphereHead } from "./sphere_head.mjs";

test("pictures of the skin are shown by the fine look and not fetched for the plain one", { timeout: 4 * PATIENCE }, async () => {
  // One pixel each, as PNG: browsers go by the content.
  const pixel = (data) => Buffer.from(`iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4n${data}AAAAAElFTkSuQmCC`, "base64");
  const green = pixel("GMQOSECAAHkAPFPioly"), matt = pixel("GNgaGAAAAEEAIFw9sel"), level = pixel("GNoaPgPAAODAgAApfuJA");
  const dressed = await startMockSession({
    quick: true, token: "t0ken", face: sphereHead({ pictures: true }),
    pictures: { "/face_albedo.jpg": green, "/face_roughness.jpg": matt, "/face_normal.jpg": level },
  });
  const troubles = [];
  const browser = await launch();
  try {
    const plain = await openPage(browser, dressed.url, troubles);
    await settled(plain, () => document.documentElement.dataset.standing === "live", "a living face");
    await plain.waitForTimeout(3000);
    const asked = (page) => page.evaluate(() => performance.getEntriesByType("resource").filter((entry) => /face_\w+\.jpg/.test(entry.name)).length);
    assert.equal(await asked(plain), 0);
    await plain.context().close();
    const address = new URL(dressed.url);
    address.searchParams.set("quality", "high");
    const fine = await openPage(browser, address.href, troubles, { fine: true });
    // Of everything on the canvas; the sensors' dots are green by 39.
    const greenness = async () => {
      const shot = (await fine.locator(".stage-canvas").screenshot({ timeout: PATIENCE })).toString("base64");
      return await fine.evaluate(async (data) => {
        const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
        const canvas = new OffscreenCanvas(image.width, image.height);
        const context = canvas.getContext("2d");
        context.drawImage(image, 0, 0);
        const { data: rgba } = context.getImageData(0, 0, image.width, image.height);
        let most = 0;
        for (let i = 0; i < rgba.length; i += 4) most = Math.max(most, rgba[i + 1] - Math.max(rgba[i], rgba[i + 2]));
        return most;
      }, shot);
    };
    let most = 0;
    for (let i = 0; i < 40 && most < 70; ++i) most = Math.max(most, await greenness());
    assert.equal(await asked(fine), 3);
    assert.ok(most >= 70, `no green skin: ${most}`);
    await fine.context().close();
    assert.deepEqual(troubles, []);
  } finally {
    await browser.close();
    await dressed.close();
  }
});
