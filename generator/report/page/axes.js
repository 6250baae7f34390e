// What lies over the pictures: scales, rings, the chosen beam and the crosshair. All in CSS pixels,
// the origin at the upper left corner of the plot.

const GRID = 'rgb(255 255 255 / 0.22)';
const CROSS = '#ffffff';
const CROSS_BACK = 'rgb(0 0 0 / 0.6)';
const CHOSEN = 'rgb(255 255 255 / 0.75)';

function strokeLine(context, style, width, points, dash = []) {
  context.strokeStyle = style;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.beginPath();
  points.forEach(({ x, y }, k) => (k === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

function writeAt(context, text, x, y, align, baseline) {
  context.textAlign = align;
  context.textBaseline = baseline;
  context.fillText(text, x, y);
}

function rangeTicks(geometry, wanted) {
  return ticks(Math.max(0, geometry.firstRange), geometry.reach, wanted);
}

function azimuthTicks(geometry, wanted) {
  const span = degrees(geometry.high - geometry.low);
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 20, 30, 45, 60, 90];
  const step = steps.find((candidate) => span / candidate <= wanted) || 90;
  const list = [];
  const last = degrees(geometry.high) + 1e-9;
  for (let k = Math.ceil(degrees(geometry.low) / step - 1e-9); k * step <= last; ++k) {
    list.push(Number((k * step).toPrecision(6)));
  }
  return list;
}

function drawPolarAxes(context, frame, geometry) {
  const { width, height } = frame;
  const yOf = (range) => ((range - geometry.firstRange) / geometry.step + 0.5) * frame.down;
  for (const range of rangeTicks(geometry, height / 60)) {
    const y = clamp(yOf(range), 0, height);
    strokeLine(context, GRID, 1, [{ x: 0, y }, { x: width, y }]);
    writeAt(context, tickText(range), -7, y, 'right', 'middle');
  }
  for (const angle of azimuthTicks(geometry, width / 52)) {
    const x = (((angle * Math.PI) / 180 - geometry.low) / geometry.spacing) * frame.across;
    strokeLine(context, GRID, 1, [{ x, y: 0 }, { x, y: height }]);
    const text = tickText(angle) + '°';
    const half = context.measureText(text).width / 2;
    writeAt(context, text, clamp(x, half - 20, width - half + 8), height + 7, 'center', 'top');
  }
  writeAt(context, '← starboard', 0, height + 23, 'left', 'top');
  writeAt(context, 'port →', width, height + 23, 'right', 'top');
  if (width > 260) writeAt(context, 'azimuth', width / 2, height + 23, 'center', 'top');
  context.save();
  context.translate(-36, height / 2);
  context.rotate(-Math.PI / 2);
  writeAt(context, 'slant range, m', 0, 0, 'center', 'bottom');
  context.restore();
}

function drawRing(context, frame, geometry, range) {
  // Angles of a canvas grow clockwise from +x; ahead is up, port is left.
  const from = -Math.PI / 2 - geometry.high;
  const to = -Math.PI / 2 - geometry.low;
  context.strokeStyle = GRID;
  context.lineWidth = 1;
  context.beginPath();
  context.arc(frame.x0, frame.y0, range * frame.scale, from, to);
  context.stroke();
}

function drawFanAxes(context, frame, geometry) {
  for (const range of rangeTicks(geometry, (geometry.reach * frame.scale) / 60)) {
    if (range === 0) continue;
    drawRing(context, frame, geometry, range);
    for (const [edge, side] of [[geometry.low, -1], [geometry.high, 1]]) {
      const at = pixelOfPolar(frame, range, edge);
      // Off the edge of the fan, at a right angle to it.
      const x = at.x - side * 9 * Math.cos(edge);
      const y = at.y + side * 9 * Math.sin(edge);
      writeAt(context, tickText(range), x, y, side < 0 ? 'left' : 'right', 'middle');
    }
  }
  for (const angle of azimuthTicks(geometry, (frame.width / 60) * 1.2)) {
    const azimuth = (angle * Math.PI) / 180;
    strokeLine(context, GRID, 1,
               [pixelOfPolar(frame, 0, azimuth), pixelOfPolar(frame, geometry.reach, azimuth)]);
    const at = pixelOfPolar(frame, geometry.reach + 14 / frame.scale, azimuth);
    writeAt(context, tickText(angle) + '°', at.x, at.y, 'center', 'middle');
  }
}

function drawChosenBeam(context, frame, geometry, beam) {
  if (beam === null) return;
  const ends = [0, geometry.samples - 1].map((n) => pixelOfCell(geometry, frame, beam, n));
  strokeLine(context, CROSS_BACK, 2.5, ends);
  strokeLine(context, CHOSEN, 1.25, ends, [5, 4]);
}

function drawCrosshair(context, frame, geometry, marker) {
  if (!marker) return;
  const { x, y } = pixelOfCell(geometry, frame, marker.beam, marker.sample);
  for (const [style, width] of [[CROSS_BACK, 3.5], [CROSS, 1.5]]) {
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      strokeLine(context, style, width,
                 [{ x: x + 5 * dx, y: y + 5 * dy }, { x: x + 14 * dx, y: y + 14 * dy }]);
    }
  }
  context.strokeStyle = CROSS;
  context.lineWidth = 1;
  context.beginPath();
  context.arc(x, y, 2, 0, 2 * Math.PI);
  context.stroke();
}
