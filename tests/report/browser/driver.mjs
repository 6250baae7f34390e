// Pages of reports in Debian's Chromium: opened from disk, with everything watched that a page must
// not do.
//
//   browser, closeBrowser   one Chromium for all tests
//   openPage                a page with its console, errors, dialogs and requests noted
//   picture, settled        what a canvas shows, and when it has stopped changing
//   shot                    a screenshot among the artefacts
import { existsSync, mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { chromium } from 'playwright-core';

const folder = resolve(process.env.REPORT_PAGES);
const artefacts = process.env.ENSONIFY_ARTEFACTS || folder;
mkdirSync(artefacts, { recursive: true });

export function file(name) {
  return join(folder, name);
}

let launched = null;

export function browser() {
  launched = launched || chromium.launch({
    executablePath: process.env.ENSONIFY_CHROMIUM || '/usr/bin/chromium',
    headless: true,
    args: ['--no-sandbox', '--disable-gpu', '--font-render-hinting=none'],
  });
  return launched;
}

export async function closeBrowser() {
  if (launched) await (await launched).close();
}

// A report opened from disk; page.faults gathers what no page may do.
export async function openPage(name, { width = 1600, height = 1000, dark = false, ratio = 1 } = {}) {
  const path = file(name);
  if (!existsSync(path)) throw new Error(`${path} is missing`);
  const page = await (await browser()).newPage({
    viewport: { width, height }, deviceScaleFactor: ratio, colorScheme: dark ? 'dark' : 'light', reducedMotion: 'reduce' });
  page.faults = [];
  page.on('console', (message) => {
    if (message.type() !== 'log') page.faults.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (error) => page.faults.push(`error: ${error.message}`));
  page.on('dialog', (dialog) => {
    page.faults.push(`dialog: ${dialog.message()}`);
    dialog.dismiss();
  });
  await page.route('**', (route) => {
    const url = route.request().url();
    if (url === `file://${path}` || url.startsWith('data:') || url.startsWith('blob:')) {
      route.continue();
      return;
    }
    page.faults.push(`request: ${url}`);
    route.abort();
  });
  await page.addInitScript(defineSum);
  await page.goto(`file://${path}`);
  await page.waitForFunction(() => document.getElementById('ping-facts')?.textContent !== '' ||
      document.getElementById('viewer')?.hidden, undefined, { timeout: 15000 });
  await settled(page);
  return page;
}

// Two sums over all pixels that no two pictures share by accident.
export async function picture(page, selector) {
  return page.$eval(selector, (canvas) => window.sumOf(canvas));
}

function defineSum() {
  window.sumOf = (canvas) => {
    const { data } = canvas.getContext('2d', { willReadFrequently: true })
        .getImageData(0, 0, canvas.width, canvas.height);
    let [a, b] = [1, 2];
    for (const pixel of new Uint32Array(data.buffer)) {
      a = Math.imul(a ^ pixel, 0x01000193);
      b = Math.imul(b, 31) + (pixel ^ (b >>> 15)) | 0;
    }
    return `${canvas.width}x${canvas.height} ${a} ${b}`;
  };
}

export const POLAR = '.pane-polar .pixels';
export const FAN = '.pane-cartesian .pixels';
export const POLAR_OVER = '.pane-polar .over';
export const FAN_OVER = '.pane-cartesian .over';

// Two frames of the screen in a row in which no canvas of the stage changes.
export async function settled(page) {
  await page.evaluate(async () => {
    const canvases = [...document.querySelectorAll('#stage .pixels')];
    const now = () => canvases.map(window.sumOf).join();
    const pause = () => new Promise((done) => setTimeout(done, 30));
    for (let before = null, same = 0; same < 2;) {
      await pause();
      const after = now();
      same = after === before ? same + 1 : 0;
      before = after;
    }
  });
}

// What polar and Cartesian picture show once `act` has been done.
export async function after(page, act) {
  await act();
  await settled(page);
  return [await picture(page, POLAR), await picture(page, FAN)];
}

export function textOf(page, selector) {
  return page.$eval(selector, (node) => node.textContent);
}

export async function readings(page) {
  return page.$$eval('[data-reading]', (nodes) => Object.fromEntries(
      nodes.map((node) => [node.dataset.reading, node.textContent])));
}

// Numbers as people read them: the minus is a minus sign.
export function number(text) {
  return Number.parseFloat(text.replace('\u2212', '-').replaceAll(',', ''));
}

export async function shot(page, name) {
  await page.screenshot({ path: join(artefacts, `report_${name}.png`), fullPage: true });
}
