// The scene from above: the way of the sonar, boxes of the objects, the fan of the ping. North is
// up, z points at the reader.

const above = { near: false };

function createAbove() {
  const choose = (near) => () => {
    above.near = near;
    drawAbove();
  };
  above.buttons = [[false, 'Whole path'], [true, 'Fan']].map(([near, text]) => el(
      'button', { type: 'button', class: 'toggle', 'data-near': String(near), text,
                  onclick: choose(near) }));
  replace(byId('above-tools'), ...above.buttons);
  on('frame', drawAbove);
  whenResized(byId('above-plot'), drawAbove);
}

// Where the beams at the edge of the ping and between them end, laid into the plane of the fan.
function fanOutline({ geometry, record }) {
  const place = record.pose.slice(0, 3);
  const rotation = record.pose.slice(3);
  const points = [place];
  const steps = 48;
  for (let k = 0; k <= steps; ++k) {
    const azimuth = geometry.low + (k / steps) * (geometry.high - geometry.low);
    const way = turned(rotation, [geometry.reach * Math.cos(azimuth),
                                  geometry.reach * Math.sin(azimuth), 0]);
    points.push(way.map((value, axis) => value + place[axis]));
  }
  return points;
}

// The outline of a box seen from above: the hull of its eight corners.
function boxOutline(box) {
  const [, sizeX, sizeY, sizeZ, x, y, z, ...rotation] = box;
  const corners = [];
  for (const sx of [-0.5, 0.5]) {
    for (const sy of [-0.5, 0.5]) {
      for (const sz of [-0.5, 0.5]) {
        const [dx, dy] = turned(rotation, [sx * sizeX, sy * sizeY, sz * sizeZ]);
        corners.push([x + dx, y + dy, z]);
      }
    }
  }
  return hull(corners);
}

function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const out = [];
    for (const p of list) {
      while (out.length > 1 && turn(out[out.length - 2], out[out.length - 1], p) <= 0) out.pop();
      out.push(p);
    }
    return out.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

function turn(a, b, c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

function spanOf(points) {
  const span = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
  for (const [x, y] of points) {
    span.left = Math.min(span.left, x);
    span.right = Math.max(span.right, x);
    span.bottom = Math.min(span.bottom, y);
    span.top = Math.max(span.top, y);
  }
  return span;
}

function middleOf(span) {
  return [(span.left + span.right) / 2, (span.bottom + span.top) / 2];
}

// Scales of one metre both ways. A seabed reaches beyond the picture: boxes far larger than fan and
// path have no say in what is shown.
function aboveScales(plot, fan, path, outlines) {
  let points = above.near ? fan : [...fan, ...path];
  const base = spanOf(points);
  const size = Math.max(base.right - base.left, base.top - base.bottom);
  const middle = middleOf(base);
  for (const { points: outline } of above.near ? [] : outlines) {
    const span = spanOf(outline);
    const own = Math.max(span.right - span.left, span.top - span.bottom);
    const at = middleOf(span);
    const far = Math.max(Math.abs(at[0] - middle[0]), Math.abs(at[1] - middle[1]));
    if (own < size && far < 2 * size) points = [...points, ...outline];
  }
  const span = spanOf(points);
  const [x, y] = middleOf(span);
  const across = plot.right - plot.left;
  const up = plot.bottom - plot.top;
  const metre = 0.92 * Math.min(across / (span.right - span.left || 1),
                                up / (span.top - span.bottom || 1));
  return {
    metre,
    x: linear(x - across / 2 / metre, x + across / 2 / metre, plot.left, plot.right),
    y: linear(y - up / 2 / metre, y + up / 2 / metre, plot.bottom, plot.top),
  };
}

function polygon(points, scales, className) {
  return svg('polygon', {
    class: className,
    points: points.map(([x, y]) => `${scales.x(x).toFixed(1)},${scales.y(y).toFixed(1)}`).join(' '),
  });
}

function drawBoxes(plot, scales, outlines, sequence) {
  const placed = [];
  // Large ones are drawn first, so that small ones can be seen; small ones are named first.
  for (const { id, points } of outlines) {
    const span = spanOf(points);
    const wide = (span.right - span.left) * scales.metre > 0.4 * (plot.right - plot.left);
    const shape = polygon(points, scales, wide ? 'box wide' : 'box');
    shape.style.fill = cssColour(nameColour(id));
    shape.style.stroke = cssColour(nameColour(id));
    shape.append(svg('title', { text: instanceName(sequence, id) }));
    plot.marks.append(shape);
  }
  for (const { id, points } of [...outlines].reverse()) {
    const [x, y] = middleOf(spanOf(points));
    const at = { x: scales.x(x), y: scales.y(y) };
    const name = instanceName(sequence, id);
    at.half = 4 * name.length;  // of the text's width, about
    const inside = at.x - at.half > plot.left && at.x + at.half < plot.right &&
        at.y > plot.top + 20 && at.y < plot.bottom - 30;
    const free = placed.every((p) => Math.abs(p.x - at.x) > p.half + at.half ||
                                     Math.abs(p.y - at.y) > 14);
    if (!inside || !free) continue;
    placed.push(at);
    plot.marks.append(label(name, at.x, at.y - 8, 'middle', 'map-name'));
  }
}

function drawScaleBar(plot, scales) {
  const length = niceStep((plot.right - plot.left) / scales.metre, 5);
  const right = plot.right - 12;
  const left = right - length * scales.metre;
  const y = plot.bottom - 12;
  plot.marks.append(
      svg('path', { class: 'scale-bar', d: `M${left} ${y - 5}V${y}H${right}V${y - 5}` }),
      label(`${tickText(length)} m`, (left + right) / 2, y - 7, 'middle', 'map-name'));
}

function drawAbove() {
  const { frame } = state;
  if (!frame) return;
  const { sequence, record } = frame;
  for (const item of above.buttons) {
    item.setAttribute('aria-pressed', String(item.dataset.near === String(above.near)));
  }
  if (!record.pose) {
    nothingHere(byId('above-plot'), 'The data set has no poses.');
    return;
  }
  const fan = fanOutline(frame);
  const path = sequence.path || [];
  const outlines = (record.boxes || []).map((box) => ({ id: box[0], points: boxOutline(box) }));
  outlines.sort((a, b) => areaOf(spanOf(b.points)) - areaOf(spanOf(a.points)));
  const [x, y, z] = record.pose;
  const plot = createPlot(byId('above-plot'), 420,
      `Seen from above: sonar at ${fixed(x, 2)} m east, ${fixed(y, 2)} m north, ${fixed(z, 2)} m up, ` +
      `${plural(outlines.length, 'box', 'boxes')} of objects.`);
  const scales = aboveScales(plot, fan, path, outlines);
  const ends = (scale, from, to) => ticks(scale.back(from), scale.back(to), 6);
  axisAcross(plot, scales.x, ends(scales.x, plot.left, plot.right), 'x, east, m');
  axisUp(plot, scales.y, ends(scales.y, plot.bottom, plot.top), 'y, north, m');
  drawBoxes(plot, scales, outlines, sequence);
  plot.marks.append(polygon(fan, scales, 'fan'));
  plot.marks.append(svg('path', {
    class: 'path', d: pathOf(path.map(([px, py]) => [scales.x(px), scales.y(py)])) }));
  plot.marks.append(svg('circle', { class: 'sonar-place', cx: scales.x(x), cy: scales.y(y), r: 4 }));
  drawScaleBar(plot, scales);
  byId('above-note').textContent =
      `sonar at ${fixed(x, 2)}, ${fixed(y, 2)}, ${fixed(z, 2)} m; z is up, towards you`;
}

function areaOf(span) {
  return (span.right - span.left) * (span.top - span.bottom);
}
