// The viewer of pings: what is shown, what changes it, and what it reads under the pointer.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after as afterAll, before, describe, test } from 'node:test';
import { FAN, FAN_OVER, POLAR, POLAR_OVER, after, file, number, openPage, picture, readings, settled,
         shot, textOf } from './driver.mjs';
import { degrees, inFan, inPolar, placeOf } from './fan.mjs';
import { levelsOf, readNpy } from './npy.mjs';

const folder = file('small/sequences/000000');
const azimuth = readNpy(`${folder}/azimuth_rad.npy`).values;
const range = readNpy(`${folder}/range_m.npy`).values;

// Levels of pictures are codes of 254 steps that went through lossy WebP. Speckle is what such
// compression blurs most: single pixels of deep nulls are off by much, half of the pixels by less
// than this.
const MEDIAN_DB = 1.5;
// Exact beams come from the EXR's halves, in steps of 1/16 dB up to 128 dB and 1/8 dB above.
const EXACT_DB = 1 / 16 + 0.006;

// Fifteen cells from all over, none of them far below the highest level.
function strongCells(levels) {
  const least = Math.max(...levels.flat()) - 60;
  const strong = levels.flatMap((series, beam) => series.map((level, sample) => [beam, sample, level]))
      .filter(([, sample, level]) => sample > 40 && level > least);
  return Array.from({ length: 15 }, (_, k) => strong[Math.floor(((k + 0.5) * strong.length) / 15)]);
}

describe('viewer', () => {
  let page;
  before(async () => { page = await openPage('small.html'); });
  afterAll(() => page.close());

  const show = (ping) => after(page, () => page.$eval('#ping-slider', (slider, value) => {
    slider.value = value;
    slider.dispatchEvent(new Event('input', { bubbles: true }));
  }, ping));

  async function changed(act, from) {
    const now = await after(page, act);
    assert.notEqual(now[0], from[0], 'the polar picture is as before');
    assert.notEqual(now[1], from[1], 'the Cartesian picture is as before');
    return now;
  }

  test('the slider moves the picture', async () => {
    const first = await show(0);
    const facts = await textOf(page, '#ping-facts');
    await changed(() => show(5), first);
    assert.notEqual(await textOf(page, '#ping-facts'), facts);
    assert.match(await textOf(page, '#ping-facts'), /ping 5\b/);
    assert.deepEqual(await show(0), first);
  });

  test('every overlay changes pixels and can be taken away', async () => {
    const plain = await show(3);
    const seen = new Set([plain[0]]);
    for (const name of ['instance', 'semantic', 'shadow']) {
      const toggle = () => page.click(`input[name=overlay][value=${name}]`);
      seen.add((await changed(toggle, plain))[0]);
      assert.deepEqual(await after(page, toggle), plain);
    }
    assert.equal(seen.size, 4, 'two overlays look the same');
  });

  test('opacity changes an overlay', async () => {
    await page.click('input[name=overlay][value=instance]');
    await settled(page);
    const first = [await picture(page, POLAR), await picture(page, FAN)];
    await changed(() => page.$eval('#opacity', (slider) => {
      slider.value = 0.9;
      slider.dispatchEvent(new Event('input'));
    }), first);
    await page.click('input[name=overlay][value=instance]');
  });

  test('expected level and elevation replace the level', async () => {
    const level = await show(3);
    const clean = await changed(() => page.click('input[value=clean]'), level);
    const elevation = await changed(() => page.click('input[value=elevation]'), clean);
    assert.notDeepEqual(elevation, level);
    assert.equal(await textOf(page, '.unit'), '°');
    assert.deepEqual(await after(page, () => page.click('input[value=level]')), level);
  });

  test('every name of the legend highlights, and lets go', async () => {
    const plain = await show(3);
    const names = await page.$$eval('button.name', (items) => items.map(
        (item) => `button.name[data-kind="${item.dataset.kind}"][data-id="${item.dataset.id}"]`));
    assert.equal(names.length, 6, 'three classes and three instances');
    for (const name of names) {
      await changed(() => page.click(name), plain);
      assert.equal(await page.$eval(name, (item) => item.getAttribute('aria-pressed')), 'true');
      assert.deepEqual(await after(page, () => page.click(name)), plain);
    }
  });

  test('colour map and limits change pixels and the colour bar', async () => {
    const seen = new Set();
    for (const map of ['viridis', 'cividis', 'grey', 'inferno']) {
      const now = await after(page, () => page.selectOption('#map', map));
      seen.add(now[0]);
    }
    assert.equal(seen.size, 4);
    const first = await show(3);
    const bar = await picture(page, '.bar');
    const type = async (field, value) => {
      await page.$eval(field, (input) => { input.value = ''; });
      await page.fill(field, value);
    };
    const low = await changed(() => type('#low-number', '75'), first);
    assert.notEqual(await picture(page, '.bar'), bar);
    await changed(() => type('#high-number', '105'), low);
    assert.deepEqual(await after(page, () => page.click('.limits .quiet')), first);
    await page.focus('#low-range');
    await changed(() => page.keyboard.press('ArrowRight'), first);
    await page.click('.limits .quiet');
  });

  test('pixels have the colour that map and limits give to the level', async () => {
    await show(0);
    await after(page, () => page.selectOption('#map', 'grey'));
    const levels = levelsOf(`${folder}/timeseries/000000.npy`);
    const limits = [];
    for (const side of ['low', 'high']) {
      limits.push(await page.$eval(`#${side}-number`, (input) => Number(input.value)));
    }
    const { width, height, data } = await page.$eval(POLAR, (canvas) => {
      const image = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      return { width: image.width, height: image.height,
               data: Array.from(image.data.filter((_, k) => k % 4 === 0)) };
    });
    const misses = [];
    levels.forEach((series, beam) => series.forEach((level, sample) => {
      const x = Math.floor(((beam + 0.5) / levels.length) * width);
      const y = Math.floor(((sample + 0.5) / series.length) * height);
      const share = (level - limits[0]) / (limits[1] - limits[0]);
      if (share > 0.05 && share < 0.95) misses.push(Math.abs(data[y * width + x] / 255 - share));
    }));
    misses.sort((a, b) => a - b);
    assert.ok(misses.length > 1000);
    const miss = misses[misses.length >> 1] * (limits[1] - limits[0]);
    assert.ok(miss < MEDIAN_DB, `half of the pixels are off by more than ${miss} dB`);
    await page.selectOption('#map', 'inferno');
  });

  // Beams and samples at the edges and between; in the fan only where a cell is a pixel or more.
  const cells = [[0, 120], [1, 60], [20, 40], [47, 80], [60, 99], [95, 110], [80, 30]];

  for (const [view, pixels, find] of [
    ['polar', POLAR, (place, beam, sample) =>
      inPolar(place, azimuth.length, range.length, beam, sample)],
    ['Cartesian', FAN, (place, beam, sample) => inFan(place, azimuth, range, beam, sample)]]) {
    test(`the pointer reads range, angle and level in the ${view} picture`, async () => {
      await show(0);
      const levels = levelsOf(`${folder}/timeseries/000000.npy`);
      const misses = [];
      for (const [beam, sample] of cells) {
        const place = await placeOf(page, pixels);
        const { x, y } = find(place, beam, sample);
        await page.mouse.move(x, y);
        const read = await readings(page);
        assert.equal(read.cell, `${beam}, ${sample}`);
        assert.ok(Math.abs(number(read.range) - range[sample]) < 0.00051, read.range);
        assert.ok(Math.abs(number(read.azimuth) - degrees(azimuth[beam])) < 0.0051, read.azimuth);
        assert.ok(read.azimuth.endsWith(azimuth[beam] > 0 ? 'port' : 'starboard'), read.azimuth);
      }
      for (const [beam, sample] of strongCells(levels)) {
        const { x, y } = find(await placeOf(page, pixels), beam, sample);
        await page.mouse.move(x, y);
        misses.push(Math.abs(number((await readings(page)).level) - levels[beam][sample]));
      }
      misses.sort((a, b) => a - b);
      assert.ok(misses[misses.length >> 1] < MEDIAN_DB, String(misses));
    });
  }

  test('port is on the left of the fan and on the right of the polar picture', async () => {
    const fan = await placeOf(page, FAN);
    await page.mouse.move(fan.x + 0.3 * fan.width, fan.y + 0.4 * fan.height);
    assert.match((await readings(page)).azimuth, /port$/);
    const polar = await placeOf(page, POLAR);
    await page.mouse.move(polar.x + 0.3 * polar.width, polar.y + 0.4 * polar.height);
    assert.match((await readings(page)).azimuth, /starboard$/);
    await page.mouse.move(fan.x + 2, fan.y + fan.height - 2);
    assert.equal((await readings(page)).range, '–');
  });

  // Where things must be seen from the sonar at (-0.6, 0), from the scenario and what it drew.
  test('the pointer reads instance and class', async () => {
    await show(0);
    const { draws } = JSON.parse(readFileSync(`${folder}/sequence.json`, 'utf8'));
    const [, drawn] = Object.entries(draws).find(([key]) => key.includes('onerror'));
    const place = await placeOf(page, POLAR);
    const nameAt = async (x, y, nearer) => {
      const beam = azimuth.findIndex((angle) => angle > Math.atan2(y, x + 0.6));
      const sample = Math.round((Math.hypot(x + 0.6, y) - nearer) / range[1]) + 1;
      const at = inPolar(place, azimuth.length, range.length, beam, sample);
      await page.mouse.move(at.x, at.y);
      const read = await readings(page);
      return `${read.instance} | ${read.class}`;
    };
    assert.equal(await nameAt(3.6, -1.1, 0.3), 'ball | ball');
    assert.equal(await nameAt(drawn, 0.9, 0.25),
                 '<img src=x onerror=alert(2)> | <img onerror=alert(3)>');
    assert.equal(await nameAt(4.5, 0, 0), 'tank | </script><script>alert(1)</script>');
    assert.equal(await nameAt(1, 0, 0), 'none | none');
  });

  test('a click chooses the beam; the exact one is exact', async () => {
    await show(0);
    const levels = levelsOf(`${folder}/timeseries/000000.npy`);
    const exact = Number(/^beam (\d+) .*exact values$/.exec(await textOf(page, '#beam-note'))[1]);
    const path = () => page.$eval('#beam-plot .level-line', (line) => line.getAttribute('d'));
    const first = await path();
    const place = await placeOf(page, POLAR);
    for (const sample of [30, 50, 70, 90]) {
      const { x, y } = inPolar(place, azimuth.length, range.length, exact, sample);
      await page.mouse.move(x, y);
      const read = await readings(page);
      assert.ok(Math.abs(number(read.level) - levels[exact][sample]) < EXACT_DB, read.level);
    }
    const other = exact > 40 ? exact - 12 : exact + 12;
    const { x, y } = inPolar(place, azimuth.length, range.length, other, 60);
    await page.mouse.click(x, y);
    assert.match(await textOf(page, '#beam-note'), new RegExp(`^beam ${other} .*from the picture`));
    assert.notEqual(await path(), first);
    await page.click('#beam-tools button');
    assert.equal(await path(), first);
  });

  test('it plays and pauses', async () => {
    await show(0);
    await page.click('.play');
    await page.waitForFunction(() => Number(document.getElementById('ping-slider').value) >= 3);
    await page.click('.play');
    await settled(page);
    const value = await page.$eval('#ping-slider', (slider) => slider.value);
    await new Promise((done) => setTimeout(done, 350));
    assert.equal(await page.$eval('#ping-slider', (slider) => slider.value), value);
  });

  test('nothing went wrong', async () => {
    await page.click('input[value=instance]');
    await page.hover(FAN_OVER);
    await page.hover(POLAR_OVER);
    await settled(page);
    await shot(page, 'viewer');
    assert.deepEqual(page.faults, []);
  });
});
