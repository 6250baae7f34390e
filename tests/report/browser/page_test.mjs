// The page as a whole: loading, strangers' names, keys, themes, widths, and what is beside the viewer.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after as afterAll, before, describe, test } from 'node:test';
import { FAN, POLAR, after, file, openPage, picture, readings, settled, shot,
         textOf } from './driver.mjs';
import { contrasts } from './contrast.mjs';

const HOSTILE = ['</script><script>alert(1)</script>', '<img onerror=alert(3)>', 'ball'];

describe('page', () => {
  let page;
  before(async () => { page = await openPage('small.html'); });
  afterAll(() => page.close());

  test('it loads from disk without a word and without a request', async () => {
    assert.deepEqual(page.faults, []);
    assert.match(await page.title(), /^small .* – ensonify report$/);
    const policy = await page.$eval('meta[http-equiv="Content-Security-Policy"]',
                                    (meta) => meta.content);
    assert.match(policy, /default-src 'none'/);
    assert.doesNotMatch(policy, /https?:|\*|connect-src|unsafe-eval/);
  });

  test('the policy stops requests', async () => {
    const other = await openPage('small.html');
    const answer = await other.evaluate(
        () => fetch('https://example.org/').then(() => 'came through', () => 'stopped'));
    assert.equal(answer, 'stopped');
    assert.ok(other.faults.some((fault) => fault.includes('Content Security Policy')));
    await other.close();
  });

  test('names of strangers are text', async () => {
    const names = await page.$$eval('.chips .name-text', (nodes) => nodes.map((n) => n.textContent));
    assert.deepEqual(names, HOSTILE);
    const legend = await page.$$eval('.names .name-text', (nodes) => nodes.map((n) => n.textContent));
    assert.ok(legend.includes('<img src=x onerror=alert(2)>'), String(legend));
    assert.equal(await textOf(page, '#title'), 'small </script><script>alert(1)</script> & co');
    assert.equal(await page.$$eval('img, iframe, object', (nodes) => nodes.length), 0);
    const scripts = await page.$$eval('script:not([type])', (nodes) => nodes.length);
    assert.equal(scripts, 1, 'a script that is not ours');
    assert.deepEqual(page.faults, []);
  });

  test('scenario and seed stand there as they are, and can be copied', async () => {
    const yaml = readFileSync(file('small/scenario.yaml'), 'utf8');
    assert.equal(await textOf(page, '#scenario-text'), yaml);
    assert.match(await textOf(page, '#facts'), /seed 7/);
    await page.click('#copy-scenario');
    await page.waitForFunction(() => document.getElementById('scenario-tools').textContent.includes('copied'));
  });

  test('the contact sheet has pages, draws small fans, and opens pings', async () => {
    const tiles = () => page.$$eval('.tile', (nodes) => nodes.length);
    assert.equal(await tiles(), 24);
    await page.$eval('#contact', (section) => section.scrollIntoView());
    await page.waitForFunction(() => [...document.querySelectorAll('.tile canvas')].every(
        (canvas) => canvas.getContext('2d', { willReadFrequently: true }).getImageData(
            canvas.width / 2, canvas.height / 2, 1, 1).data[3] === 255));
    const fans = await page.$$eval('.tile canvas', (nodes) => nodes.map(window.sumOf));
    assert.equal(new Set(fans).size, 24, 'two pings look the same');
    await page.click('.contact-sheet li:nth-child(6) .tile');
    await settled(page);
    assert.match(await textOf(page, '#ping-facts'), /ping 5\b/);
    await page.click('#contact-tools button:last-child');
    assert.equal(await tiles(), 4);
    assert.equal(await page.$$eval('.tile[aria-current]', (nodes) => nodes.length), 0);
    await page.click('.contact-sheet li:nth-child(4) .tile');
    await settled(page);
    assert.match(await textOf(page, '#ping-facts'), /sequence 1 .*ping 13\b/);
    await page.$eval('.play', (play) => play.closest('.buttons').firstElementChild.click());
    await settled(page);
  });

  test('the fan moves over the map, among a box for each object', async () => {
    const fan = () => page.$eval('#above-plot .fan', (shape) => shape.getAttribute('points'));
    const first = await fan();
    assert.equal(await page.$$eval('#above-plot .box', (nodes) => nodes.length), 3);
    await after(page, () => page.$eval('.buttons', (group) => group.children[3].click()));
    assert.notEqual(await fan(), first);
    await page.$eval('.buttons', (group) => group.children[0].click());
    await settled(page);
    const whole = await fan();
    await page.click('#above-tools [data-near=true]');
    assert.notEqual(await fan(), whole);
  });

  test('draws, splits, classes, ranges and speckle are there', async () => {
    const draws = await textOf(page, '#draws-table');
    assert.match(draws, /materials\.steel\.reflectivity/);
    assert.match(await textOf(page, '#splits-table'), /val.*2.*28/);
    const rows = await page.$$eval('#counts-table tbody tr', (nodes) => nodes.map(
        (row) => row.firstElementChild.textContent));
    assert.deepEqual(rows.sort(), [...HOSTILE].sort());
    assert.ok(await page.$('#ranges-plot svg rect[style]'));
    assert.ok(await page.$('#speckle-plot svg, #speckle-plot .nothing'));
  });
});

describe('keys', () => {
  let page;
  before(async () => { page = await openPage('small.html'); });
  afterAll(() => page.close());

  const ping = () => page.$eval('#ping-slider', (slider) => Number(slider.value));
  const press = async (key) => {
    await page.keyboard.press(key);
    await settled(page);
  };

  test('arrows, Page, Home and End turn over pings', async () => {
    await press('ArrowRight');
    assert.equal(await ping(), 1, 'with the focus nowhere');
    await page.focus('#ping-slider');
    const first = await picture(page, POLAR);
    for (const [key, wanted] of [['ArrowRight', 2], ['ArrowLeft', 1], ['PageDown', 11],
                                 ['PageUp', 1], ['End', 27], ['Home', 0]]) {
      await press(key);
      assert.equal(await ping(), wanted, key);
    }
    assert.notEqual(await picture(page, POLAR), first);
  });

  test('everything is reached by Tab, in sight and with a name', async () => {
    // Of radio buttons Tab stops at one; boxes that scroll it may stop at too.
    const wanted = await page.$$eval('main button, main input, main select, main canvas[tabindex], ' +
        'main summary, main pre[tabindex]', (nodes) => nodes.filter(
        (node) => !node.disabled && node.type !== 'radio' && node.checkVisibility()).map(
        (node, k) => { node.dataset.tabbed = String(k); }).length);
    await page.focus('#theme');
    const seen = new Set();
    for (let k = 0; k < wanted + 30; ++k) {
      await page.keyboard.press('Tab');
      const found = await page.evaluate(() => {
        const node = document.activeElement;
        if (!document.getElementById('main').contains(node)) return null;
        const style = getComputedStyle(node);
        const label = node.getAttribute('aria-label') || node.textContent.trim() ||
            (node.labels && node.labels[0] && node.labels[0].textContent);
        return { key: node.dataset.tabbed, label,
                 outline: style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 1 };
      });
      if (!found) continue;
      assert.ok(found.outline, `no outline: ${found.label}`);
      assert.ok(found.label, 'a control without a name');
      if (found.key !== undefined) seen.add(found.key);
    }
    assert.equal(seen.size, wanted);
  });

  test('a crosshair reads without a mouse', async () => {
    await page.focus('.pane-cartesian .over');
    await press('ArrowUp');
    const first = await readings(page);
    assert.notEqual(first.range, '–');
    const [beam, sample] = first.cell.split(', ').map(Number);
    await press('ArrowUp');
    await press('ArrowLeft');
    assert.equal((await readings(page)).cell, `${beam + 1}, ${sample + 1}`, 'further and to port');
    await page.keyboard.down('Shift');
    await press('ArrowRight');
    await page.keyboard.up('Shift');
    assert.equal((await readings(page)).cell, `${beam - 9}, ${sample + 1}`);
    assert.match(await textOf(page, '#live'), /^Range .* m, azimuth .*, level /);
    await press('Enter');
    assert.match(await textOf(page, '#beam-note'), new RegExp(`^beam ${beam - 9} `));
    await press('Escape');
    assert.equal((await readings(page)).range, '–');
    await page.focus('.pane-polar .over');
    await press('ArrowRight');
    await press('ArrowDown');
    assert.notEqual((await readings(page)).range, '–');
  });

  test('names of the legend take Enter and let go by Escape', async () => {
    await page.focus('.names button');
    const plain = await picture(page, FAN);
    await press('Enter');
    assert.notEqual(await picture(page, FAN), plain);
    await press('Escape');
    assert.equal(await picture(page, FAN), plain);
    assert.deepEqual(page.faults, []);
  });
});

describe('looks', () => {
  for (const dark of [false, true]) {
    test(`${dark ? 'dark' : 'light'} can be read: contrast of all text`, async () => {
      const page = await openPage('small.html', { dark });
      const low = (await contrasts(page)).filter(({ ratio }) => ratio < 4.5);
      assert.deepEqual(low, []);
      await shot(page, dark ? 'dark' : 'light');
      await page.close();
    });
  }

  test('the choice of theme goes before the system', async () => {
    const page = await openPage('small.html');
    const ground = () => page.evaluate(
        () => getComputedStyle(document.documentElement).backgroundColor);
    const light = await ground();
    await page.selectOption('#theme', 'dark');
    const dark = await ground();
    assert.notEqual(dark, light);
    await page.emulateMedia({ colorScheme: 'dark' });
    await page.selectOption('#theme', 'light');
    assert.equal(await ground(), light);
    await page.selectOption('#theme', 'auto');
    assert.equal(await ground(), dark);
    await page.close();
  });

  for (const width of [400, 1600]) {
    test(`${width} px are enough`, async () => {
      const page = await openPage('small.html', { width });
      const widest = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(widest <= width, `${widest} px`);
      const tops = await page.$$eval('.pane', (nodes) => nodes.map(
          (node) => node.getBoundingClientRect().top));
      assert.equal(tops[0] === tops[1], width === 1600, 'side by side where there is room');
      const outside = await page.$$eval('main *', (nodes, limit) => nodes.filter((node) => {
        const { right, width: own } = node.getBoundingClientRect();
        return own > 1 && right > limit + 1 && !node.closest('pre, .table-box, svg');
      }).map((node) => node.className || node.id || node.tagName), width);
      assert.deepEqual(outside, []);
      await shot(page, `width_${width}`);
      assert.deepEqual(page.faults, []);
      await page.close();
    });
  }

  test('fine screens get fine pictures', async () => {
    const page = await openPage('small.html', { ratio: 2 });
    const ratio = await page.$eval(FAN, (canvas) => canvas.width / canvas.clientWidth);
    assert.ok(Math.abs(ratio - 2) < 0.01, String(ratio));
    await page.close();
  });
});
