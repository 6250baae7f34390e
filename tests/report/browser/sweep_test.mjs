// The page over the runs of a sweep: table, figure and images, and that they show the same runs.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after as afterAll, before, describe, test } from 'node:test';
import { contrasts } from './contrast.mjs';
import { file, openPage, picture, shot, textOf } from './driver.mjs';

// Commas within quotes are part of a name.
const cellsOf = (line) => line.split(/,(?=(?:[^"]*"[^"]*")*[^"]*$)/).map((cell) => cell.replace(/^"|"$/g, ''));
const [names, ...rows] = readFileSync(file('sweep/runs.csv'), 'utf8').trim().split('\n').map(cellsOf);
const column = (name) => names.indexOf(name);

describe('sweep', () => {
  let page;
  before(async () => { page = await openPage('sweep.html'); });
  afterAll(() => page.close());

  const shown = () => page.$$eval('#runs-table tbody tr', (nodes) => nodes.map((node) => node.dataset.run));
  const ids = (some) => some.map((row) => row[0]);
  const choose = (id, value) => page.selectOption(id, value);
  const drawn = () => page.waitForFunction(() => [...document.querySelectorAll('.tile canvas')].every(
      (canvas) => canvas.dataset.drawn));

  test('it loads from disk without a word, and names of strangers are text', async () => {
    assert.equal(await textOf(page, '#title'), 'tiny </script><script>alert(1)</script>');
    assert.match(await textOf(page, '#facts'), /8 runs.*8 pings.*f: 2 values/);
    assert.equal(await page.$$eval('b, img', (nodes) => nodes.length), 0);
    assert.ok(!await page.$eval('#notice', (node) => node.checkVisibility()));
    assert.deepEqual(await shown(), ids(rows));
    assert.deepEqual(page.faults, []);
  });

  test('the table is that of the sweep, and a column sorts it both ways', async () => {
    const heads = await page.$$eval('#runs-table th', (nodes) => nodes.map((node) => node.textContent));
    const cells = await page.$$eval('#runs-table tbody tr', (nodes) => nodes.map(
        (row) => [...row.cells].map((cell) => cell.textContent)));
    rows.forEach((row, k) => heads.forEach((head, n) => assert.equal(cells[k][n], row[column(head)])));
    assert.ok(heads.includes('max_level_db') && !heads.includes('contrast'), String(heads));
    const by = (sign) => ids([...rows].sort(
        (a, b) => sign * (a[column('max_level_db')] - b[column('max_level_db')])));
    await page.click('#sort-max_level_db');
    assert.deepEqual(await shown(), by(1));
    await page.click('#sort-max_level_db');
    assert.deepEqual(await shown(), by(-1));
    assert.equal(await page.$eval('th[aria-sort]', (node) => node.getAttribute('aria-sort')), 'descending');
  });

  test('a point stands where its number and its axis say', async () => {
    await choose('#metric-y', 'max_level_db');
    await choose('#metric-x', 'axis_pings');
    await choose('#metric-by', 'bottom');
    const points = await page.$$eval('.point', (nodes) => nodes.map(
        (node) => [node.dataset.run, Number(node.getAttribute('cx')), Number(node.getAttribute('cy'))]));
    assert.equal(points.length, 8);
    const level = (run) => Number(rows.find((row) => row[0] === run)[column('max_level_db')]);
    const range = (run) => Number(rows.find((row) => row[0] === run)[column('axis_pings')]);
    const [first] = points;
    const other = points.find(([run]) => level(run) !== level(first[0]));
    const slope = (other[2] - first[2]) / (level(other[0]) - level(first[0]));
    for (const [run, x, y] of points) {
      assert.ok(Math.abs(y - first[2] - slope * (level(run) - level(first[0]))) < 0.5, run);
      assert.equal(Math.sign(x - first[1]), Math.sign(range(run) - range(first[0])), run);
    }
    assert.ok(slope < 0);
    assert.match(await textOf(page, '#metric-keys'), /bottom soft.*bottom <b>hard<\/b>/);
  });

  test('images have one display', async () => {
    await page.$eval('#images', (node) => node.scrollIntoView());
    await drawn();
    const before = await page.$$eval('.tile canvas', (nodes) => nodes.map(window.sumOf));
    assert.equal(new Set(before).size, 8, 'two runs look the same');
    assert.match(await textOf(page, '#images-note'), /ping 0 of sequence 0/);
    await page.fill('#limit-low', '20');
    await page.press('#limit-low', 'Enter');
    await page.waitForFunction(() => [...document.querySelectorAll('.tile canvas')].every(
        (canvas) => canvas.dataset.drawn.startsWith('inferno 20 ')));
    const after = await page.$$eval('.tile canvas', (nodes) => nodes.map(window.sumOf));
    after.forEach((sum, k) => assert.notEqual(sum, before[k]));
    await choose('#limit-map', 'grey');
    await page.waitForFunction(() => [...document.querySelectorAll('.tile canvas')].every(
        (canvas) => canvas.dataset.drawn.startsWith('grey')));
    assert.notEqual(await picture(page, '.tile canvas'), after[0]);
  });

  test('a choice of values and a marked run hold in all parts', async () => {
    await choose('#only-f', { index: 2 });
    const half = rows.filter((row) => row[column('f')] === rows[7][column('f')]);
    assert.deepEqual((await shown()).sort(), ids(half).sort());
    for (const mark of ['.tile', '.point']) {
      assert.deepEqual((await page.$$eval(mark, (nodes) => nodes.map((node) => node.dataset.run))).sort(),
                       ids(half).sort());
    }
    await page.click(`.tile[data-run="${half[1][0]}"]`);
    for (const mark of ['#runs-table tr', '.tile', '.point']) {
      assert.deepEqual(await page.$$eval(`${mark}[aria-current]`, (nodes) => nodes.map((node) => node.dataset.run)),
                       [half[1][0]]);
    }
    assert.equal(await textOf(page, '#chosen-note'), '4 of 8 runs');
    await choose('#only-f', { index: 0 });
    await drawn();
    await shot(page, 'sweep');
    assert.deepEqual(page.faults, []);
  });

  test('a run that is not done is named, and is nowhere but in the table', async () => {
    const other = await openPage('part.html');
    const lost = ids(rows).sort()[0];
    assert.match(await textOf(other, '#notice'), new RegExp(`^1 run of 8 is not done.*${lost} .*: missing$`));
    assert.equal((await other.$$('.tile')).length, 7);
    assert.equal((await other.$$('.point')).length, 7);
    assert.equal((await other.$$('#runs-table tbody tr')).length, 8);
    assert.match(await textOf(other, '#metric-note'), /1 of the shown runs has no mean_level_db/);
    assert.deepEqual(other.faults, []);
    await other.close();
  });

  for (const dark of [false, true]) {
    test(`${dark ? 'dark' : 'light'} can be read: contrast of all text`, async () => {
      const other = await openPage('sweep.html', { dark });
      await other.click('#runs-table tbody tr');
      assert.deepEqual((await contrasts(other)).filter(({ ratio }) => ratio < 4.5), []);
      await other.close();
    });
  }
});
