// How soon the page shows a face, and how many pictures a second it draws: in headless Chromium whose graphics card is
// software, 1280 x 800. Counts the canvas's own draw calls, so it measures any version of the page alike. Start a session
// first (`mien live`, and `mien perform --loop` that moves the face), then
//
//   npm run bench:page -- http://127.0.0.1:8740 [SECONDS] [ROUNDS]
//
// Prints a row a round: ms from the address to the first picture with a head, pictures a second and the canvas's size
// over the last half of SECONDS (20), since the page begins fine and gets coarser where a card is slow.
//
//   MIEN_CHROMIUM     the browser (/usr/bin/chromium)
import { chromium } from "playwright-core";

const [url = "http://127.0.0.1:8740", seconds = "20", rounds = "3"] = process.argv.slice(2);
const GL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
/** Indices of one draw call that only a head has. */
const HEAD = 20_000;

/** In the page, before anything of it: notes when pictures are drawn. */
function watch(head) {
  const seen = (globalThis.drawn = { first: 0, times: [], width: 0, height: 0 });
  const of = WebGL2RenderingContext.prototype;
  for (const name of ["drawElements", "drawElementsInstanced"]) {
    const draw = of[name];
    of[name] = function (mode, count, ...rest) {
      const done = draw.call(this, mode, count, ...rest);
      if (count < head) return done;
      if (!seen.first) {
        this.finish();
        seen.first = performance.now();
      }
      // All passes of one picture are drawn in one frame of the browser.
      if (seen.frame !== document.timeline.currentTime) seen.times.push(performance.now());
      seen.frame = document.timeline.currentTime;
      seen.width = this.drawingBufferWidth;
      seen.height = this.drawingBufferHeight;
      return done;
    };
  }
}

const browser = await chromium.launch({
  executablePath: process.env.MIEN_CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless=new", "--no-sandbox", ...GL],
});
console.log("round  first picture, ms  pictures a second  canvas");
for (let round = 1; round <= Number(rounds); ++round) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  const page = await context.newPage();
  await page.addInitScript(watch, HEAD);
  await page.goto(url);
  await page.waitForFunction(() => globalThis.drawn.first > 0, undefined, { timeout: 120_000, polling: 100 });
  await page.waitForTimeout(Number(seconds) * 1000);
  const row = await page.evaluate((half) => {
    const { first, times, width, height } = globalThis.drawn;
    const late = times.filter((time) => time > performance.now() - half);
    return { first, rate: (late.length * 1000) / half, width, height };
  }, Number(seconds) * 500);
  console.log(
    `${String(round).padEnd(5)}  ${row.first.toFixed(0).padStart(17)}  ${row.rate.toFixed(1).padStart(17)}  ${row.width} x ${row.height}`,
  );
  await context.close();
}
await browser.close();
