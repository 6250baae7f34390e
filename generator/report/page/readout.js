// What is under the pointer or the crosshair, as text, and for screen readers as a sentence.

const READINGS = [
  ['range', 'Slant range'], ['azimuth', 'Azimuth'], ['cell', 'Beam, sample'], ['level', 'Level'],
  ['clean', 'Expected'], ['elevation', 'Elevation'], ['instance', 'Instance'],
  ['class', 'Class'], ['shadow', 'In the shadow of'],
];

function createReadout(list) {
  const values = {};
  const items = list.map(([key, title]) => {
    values[key] = el('dd', { 'data-reading': key, text: '–' });
    return el('div', { class: `reading reading-${key}` }, el('dt', { text: title }), values[key]);
  });
  replace(byId('readout'), ...items);
  return values;
}

// A level of the frame at a cell: exact where the ping has the beam exactly, else as the picture
// has it, in steps of its 254 codes.
function levelAt(frame, quantity, cell) {
  const index = cell.sample * frame.geometry.beams + cell.beam;
  if (frame.exact && frame.exact.beam === cell.beam && frame.exact[quantity]) {
    return { value: frame.exact[quantity][cell.sample], exact: true };
  }
  const codes = frame.codes[quantity];
  return codes ? { value: decode(codes[index], codingOf(quantity)), exact: false } : null;
}

function levelText(reading) {
  if (!reading) return 'not in the data set';
  if (Number.isNaN(reading.value)) return reading.exact ? 'no energy' : 'none or too little';
  return reading.exact ? `${fixed(reading.value, 2)} dB` : `${fixed(reading.value, 1)} dB`;
}

function readAt(frame, cell) {
  const { geometry, sequence } = frame;
  const index = cell.sample * geometry.beams + cell.beam;
  const range = rangeOf(geometry, cell.sample);
  const azimuth = degrees(sequence.azimuth_rad[cell.beam]);
  const side = Math.abs(azimuth) < 0.005 ? '' : azimuth > 0 ? ' port' : ' starboard';
  const elevation = levelAt(frame, 'elevation', cell);
  const nameOf = (ids) =>
      ids ? (ids[index] ? instanceName(sequence, ids[index]) : 'none') : 'not in the data set';
  return {
    range: `${fixed(range, 3)} m`,
    azimuth: `${fixed(azimuth, 2)}°${side}`,
    cell: `${cell.beam}, ${cell.sample}`,
    level: levelText(levelAt(frame, 'level', cell)),
    clean: levelText(levelAt(frame, 'clean', cell)),
    elevation: !elevation ? 'not in the data set'
        : Number.isNaN(elevation.value) ? 'none' : `${fixed(elevation.value, 1)}°`,
    instance: nameOf(frame.instance),
    class: !frame.semantic ? 'not in the data set'
        : frame.semantic[index] ? className(frame.semantic[index]) : 'none',
    shadow: nameOf(frame.shadow),
  };
}

function showReading(values, frame, cell) {
  const reading = frame && cell ? readAt(frame, cell) : null;
  writeReading(values, reading);
  return reading;
}

function writeReading(values, reading) {
  for (const key of Object.keys(values)) {
    const text = reading ? reading[key] : '–';
    values[key].textContent = text;
    values[key].classList.toggle('faint', text === 'not in the data set' || text === 'none');
  }
}

function spokenReading(reading) {
  if (!reading) return 'No crosshair.';
  const named = reading.instance === 'none' || reading.instance === 'not in the data set'
      ? '' : `, ${reading.instance}, ${reading.class}`;
  return `Range ${reading.range}, azimuth ${reading.azimuth}, level ${reading.level}${named}.`;
}
