// Other data sets: statistics without pings, series without pictures, more pings than are shown.
import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { FAN, POLAR, after, file, number, openPage, picture, readings, shot,
         textOf } from './driver.mjs';
import { inPolar, placeOf } from './fan.mjs';
import { readNpy } from './npy.mjs';

describe('statistics', () => {
  test('contrast and mean intensity are shown and read', async () => {
    const page = await openPage('statistics.html');
    const contrast = readNpy(file('statistics/sequences/000000/statistics/contrast.npy'));
    const [samples, beams] = contrast.shape[1] === 64 ? contrast.shape : [...contrast.shape].reverse();
    const transposed = contrast.shape[1] !== 64;
    const at = (beam, sample) => contrast.values[transposed ? beam * samples + sample
                                                            : sample * beams + beam];
    const names = await page.$$eval('input[name=statistic]', (nodes) => nodes.map(
        (node) => node.parentElement.textContent));
    assert.ok(names.includes('contrast') && names.includes('mean intensity'), String(names));
    await after(page, () => page.$$eval(
        'input[name=statistic]', (nodes, k) => nodes[k].click(), names.indexOf('contrast')));
    const place = await placeOf(page, POLAR);
    const step = 2 / 254;  // the page's codes of contrast go from 0 to 2, whatever the values
    for (const [beam, sample] of [[5, 75], [32, 80], [60, 70]]) {
      const { x, y } = inPolar(place, beams, samples, beam, sample);
      await page.mouse.move(x, y);
      const read = await readings(page);
      assert.equal(read.cell, `${beam}, ${sample}`);
      assert.ok(Math.abs(number(read.value) - at(beam, sample)) <= 0.51 * step + 0.001,
                `${read.value} for ${at(beam, sample)}`);
    }
    const first = [await picture(page, POLAR), await picture(page, FAN)];
    const other = names.indexOf('mean intensity');
    const now = await after(page, () => page.$$eval(
        'input[name=statistic]', (nodes, k) => nodes[k].click(), other));
    assert.notEqual(now[0], first[0]);
    assert.notEqual(now[1], first[1]);
    const next = await after(page, () => page.$eval('#ping-slider', (slider) => {
      slider.value = 1;
      slider.dispatchEvent(new Event('input'));
    }));
    assert.notEqual(next[0], now[0], 'both sequences look the same');
    assert.match(await textOf(page, '#ping-facts'), /sequence 1 .*40 realisations/);
    assert.ok(!await page.$eval('#contact', (node) => node.checkVisibility()));
    await shot(page, 'statistics');
    assert.deepEqual(page.faults, []);
    await page.close();
  });
});

describe('a data set of series alone', () => {
  test('what it lacks is out of reach and says why', async () => {
    const page = await openPage('bare.html');
    for (const name of ['clean', 'elevation', 'instance', 'semantic', 'shadow']) {
      const [disabled, text] = await page.$eval(
          `input[value=${name}]`, (input) => [input.disabled, input.parentElement.textContent]);
      assert.ok(disabled, name);
      assert.match(text, /not in the data set/);
    }
    const place = await placeOf(page, FAN);
    await page.mouse.move(place.x + place.width / 2, place.y + place.height / 3);
    const read = await readings(page);
    assert.match(read.range, / m$/);
    assert.equal(read.instance, 'not in the data set');
    assert.match(await textOf(page, '#speckle-plot'), /No pixels/);
    const first = await picture(page, FAN);
    await page.focus('#ping-slider');
    const now = await after(page, () => page.keyboard.press('ArrowRight'));
    assert.notEqual(now[1], first);
    await shot(page, 'bare');
    assert.deepEqual(page.faults, []);
    await page.close();
  });
});

describe('more pings than are shown', () => {
  test('the page says so', async () => {
    const page = await openPage('sampled.html');
    assert.match(await textOf(page, '#notice'), /5 of 28 pings/);
    assert.match(await textOf(page, '#contact-note'), /5 of 28 pings/);
    assert.equal(await page.$$eval('.tile', (nodes) => nodes.length), 5);
    assert.match(await textOf(page, '#facts'), /28 pings/);
    await page.close();
    const whole = await openPage('small.html');
    assert.ok(!await whole.$eval('#notice', (node) => node.checkVisibility()));
    await whole.close();
  });
});
