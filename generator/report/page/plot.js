// Plots as SVG, in pixels of the screen: a frame, scales, ticks, and a new drawing where the room
// for it changes.

function whenResized(container, draw) {
  let known = 0;
  new ResizeObserver(oncePerFrame(() => {
    if (container.clientWidth === known) return;
    known = container.clientWidth;
    draw();
  })).observe(container);
}

const PLOT_MARGIN = { left: 56, right: 14, top: 12, bottom: 42 };

function createPlot(container, height, label, margin = PLOT_MARGIN) {
  const width = Math.max(220, container.clientWidth);
  const root = svg('svg', { width, height, viewBox: `0 0 ${width} ${height}`, role: 'img',
                            'aria-label': label });
  const plot = {
    root, width, height, left: margin.left, top: margin.top,
    right: width - margin.right, bottom: height - margin.bottom,
  };
  const id = `clip-${container.id}`;
  root.append(svg('clipPath', { id }, svg('rect', {
    x: plot.left, y: plot.top, width: plot.right - plot.left, height: plot.bottom - plot.top })));
  plot.grid = svg('g', { class: 'grid' });
  plot.marks = svg('g', { 'clip-path': `url(#${id})` });
  plot.text = svg('g', { class: 'axis' });
  root.append(plot.grid, plot.marks, plot.text);
  replace(container, root);
  return plot;
}

function linear(low, high, from, to) {
  const scale = (value) => from + ((value - low) / (high - low)) * (to - from);
  scale.back = (pixel) => low + ((pixel - from) / (to - from)) * (high - low);
  return scale;
}

function logarithmic(low, high, from, to) {
  const inner = linear(Math.log10(low), Math.log10(high), from, to);
  return (value) => inner(Math.log10(value));
}

function line(x1, y1, x2, y2, className) {
  return svg('line', { x1, y1, x2, y2, class: className || null });
}

function label(text, x, y, anchor, className) {
  return svg('text', { x, y, 'text-anchor': anchor, class: className || null, text });
}

function axisAcross(plot, scale, values, title, textOf = tickText) {
  for (const value of values) {
    const x = scale(value);
    plot.grid.append(line(x, plot.top, x, plot.bottom));
    plot.text.append(label(textOf(value), x, plot.bottom + 16, 'middle'));
  }
  plot.text.append(label(title, (plot.left + plot.right) / 2, plot.bottom + 34, 'middle', 'title'));
}

function axisUp(plot, scale, values, title, textOf = tickText) {
  for (const value of values) {
    const y = scale(value);
    plot.grid.append(line(plot.left, y, plot.right, y));
    plot.text.append(label(textOf(value), plot.left - 8, y + 4, 'end'));
  }
  const middle = (plot.top + plot.bottom) / 2;
  const text = label(title, 14, middle, 'middle', 'title');
  text.setAttribute('transform', `rotate(-90 14 ${middle})`);
  plot.text.append(text);
}

// A path over points, broken where one is not a number.
function pathOf(points) {
  let path = '';
  let pen = 'M';
  for (const [x, y] of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) {
      pen = 'M';
      continue;
    }
    path += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  }
  return path;
}

function keyItem(className, text) {
  const sample = svg('svg', { width: 26, height: 10, 'aria-hidden': 'true' },
                     svg('line', { x1: 1, y1: 5, x2: 25, y2: 5, class: className }));
  return el('span', { class: 'key' }, sample, el('span', { text }));
}

function nothingHere(container, text) {
  replace(container, el('p', { class: 'nothing', text }));
}
