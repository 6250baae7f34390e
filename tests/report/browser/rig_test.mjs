// The page over the instruments of a rig: their table, and the images of one time in a row.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { contrasts } from './contrast.mjs';
import { openPage, shot, textOf } from './driver.mjs';

test('a rig shows its instruments, and their pings of one time in a row', async () => {
  const page = await openPage('rig.html', { height: 4000 });
  assert.equal(await textOf(page, '#title'), 'rig </script><script>alert(1)</script>');
  assert.deepEqual(await page.$$eval('#instruments-table a', (nodes) => nodes.map((node) => [node.textContent, node.getAttribute('href')])),
                   [['left', 'rig_left.html'], ['right', 'rig_right.html']]);
  const words = await page.$$eval('#pings-table td > div', (nodes) => nodes.map((node) => node.textContent));
  assert.deepEqual(words, ['ping 0, 0.000 s', 'ping 0, 0.100 s', 'ping 0, 0.000 s', 'ping 1, 0.500 s', 'ping 2, 0.600 s',
                           'ping 1, 0.500 s', 'ping 2, 1.000 s', 'ping 4, 1.100 s', 'ping 2, 1.000 s']);
  await page.waitForFunction(() => [...document.querySelectorAll('canvas')].every((canvas) => canvas.dataset.drawn));
  // In a row, the levels of two, and color and depth of the camera.
  const sums = await page.$$eval('canvas', (nodes) => nodes.map(window.sumOf));
  assert.equal(sums.length, 12);
  // The fans differ, and the camera sees the same.
  assert.equal(new Set(sums).size, 8);
  const [red, green, blue] = await page.$$eval('canvas', ([, , color]) => [...color.getContext('2d').getImageData(20, 15, 1, 1).data]);
  assert.ok(red > green + 20 && green > blue + 20, `${red} ${green} ${blue}`);
  assert.deepEqual((await contrasts(page)).filter(({ ratio }) => ratio < 4.5), []);
  await shot(page, 'rig');
  assert.deepEqual(page.faults, []);
  await page.close();
});
