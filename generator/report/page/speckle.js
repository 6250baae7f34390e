// Histogram of the intensity over its expectation, on the law of fully developed speckle, exp(-x).

function createSpeckle() {
  const { speckle } = report;
  if (!speckle || !speckle.pixels) {
    nothingHere(byId('speckle-plot'),
                'No pixels to judge speckle by: it takes expected levels, well above the noise.');
    return;
  }
  byId('speckle-note').textContent = `contrast ${fixed(speckle.contrast, 4)} ± ` +
      `${fixed(speckle.contrast_standard_error, 4)} (theory 1), mean ${fixed(speckle.mean, 4)}`;
  drawSpeckle();
  whenResized(byId('speckle-plot'), drawSpeckle);
}

function densities({ edges, counts, pixels }) {
  return counts.map((count, k) => count / pixels / (edges[k + 1] - edges[k]));
}

function powerText(value) {
  const digits = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  const power = Math.round(Math.log10(value));
  return power === 0 ? '1' : `10⁻${[...String(-power)].map((digit) => digits[digit]).join('')}`;
}

function drawSpeckle() {
  const { speckle } = report;
  const { edges, counts } = speckle;
  const end = edges[edges.length - 1];
  const density = densities(speckle);
  const least = Math.min(Math.exp(-end), ...density.filter((value) => value > 0));
  const box = byId('speckle-plot');
  const plot = createPlot(box, 340, `Histogram of ${whole(speckle.pixels)} pixels' intensity over ` +
      `its expectation, beside exp(-x). Contrast ${fixed(speckle.contrast, 4)}, theory 1.`);
  const low = 10 ** Math.floor(Math.log10(least));
  const x = linear(edges[0], end, plot.left, plot.right);
  const y = logarithmic(low, 2, plot.bottom, plot.top);
  axisAcross(plot, x, ticks(edges[0], end, 10), 'intensity over its expectation');
  const powers = [];
  for (let k = Math.log10(low); k <= 0.1; ++k) powers.push(10 ** Math.round(k));
  axisUp(plot, y, powers, 'density', powerText);
  counts.forEach((count, k) => {
    if (count === 0) return;
    const top = y(density[k]);
    const bar = svg('rect', { class: 'histogram', x: x(edges[k]), y: top,
                              width: Math.max(0.5, x(edges[k + 1]) - x(edges[k]) - 1),
                              height: plot.bottom - top });
    bar.append(svg('title', { text: `${brief(edges[k])} to ${brief(edges[k + 1])}: ${whole(count)}` }));
    plot.marks.append(bar);
  });
  const points = Array.from({ length: 121 }, (_, k) => edges[0] + (k / 120) * (end - edges[0]));
  plot.marks.append(svg('path', { class: 'theory',
                                  d: pathOf(points.map((value) => [x(value), y(Math.exp(-value))])) }));
  const beyond = speckle.over ? ` ${whole(speckle.over)} beyond ${brief(end)}.` : '';
  box.append(el('div', { class: 'plot-keys' }, keyItem('histogram-line', 'pixels'),
                keyItem('theory', 'exp(−x)')),
             el('p', { class: 'hint', text: `${whole(speckle.pixels)} pixels of ` +
                 `${plural(speckle.pings, 'ping')}.${beyond} ${speckle.what || ''}` }));
}
