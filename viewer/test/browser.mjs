// A real browser for the page's tests.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

/** A graphics card made of software is slow, and the machine may be busy: ms. */
export const PATIENCE = 150_000;
export const GL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** By default with a graphics card of software. */
export async function launch(...gl) {
  const executablePath = process.env.MIEN_CHROMIUM ?? "/usr/bin/chromium";
  assert.ok(existsSync(new URL("../dist/page.js", import.meta.url)), "The page is not built: npm run build.");
  assert.ok(existsSync(executablePath), `There is no browser at ${executablePath}; MIEN_CHROMIUM says where it is.`);
  return await chromium.launch({ executablePath, args: ["--headless=new", "--no-sandbox", ...(gl.length > 0 ? gl : GL)], timeout: PATIENCE });
}

/**
 * What is said on the console is added to `troubles`, but for a session that goes while it gives a file. `options.fine`: not
 * of the coarsest quality.
 */
export async function openPage(browser, url, troubles, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 640 }, reducedMotion: "reduce", ...options });
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  page.on("pageerror", (error) => troubles.push(String(error.stack)));
  page.on("console", (message) => {
    if (message.type() === "error" && !/ERR_CONNECTION_REFUSED|ERR_SOCKET_NOT_CONNECTED|ERR_CONTENT_LENGTH_MISMATCH|WebSocket connection|40[34]/.test(message.text())) troubles.push(message.text());
  });
  const address = new URL(url);
  if (!options.fine) address.searchParams.set("quality", "low");
  await page.goto(address.href, { timeout: PATIENCE });
  return page;
}

export async function settled(page, condition, what, argument) {
  await page.waitForFunction(condition, argument, { timeout: PATIENCE, polling: 100 }).catch((error) => {
    throw new Error(`${what}: ${error.message}`);
  });
}
