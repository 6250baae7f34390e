// What is under the pointer or the crosshair, as text, and for screen readers as a sentence.

const READINGS = [
  ['range', 'Slant range'], ['azimuth', 'Azimuth'], ['cell', 'Beam, sample'], ['level', 'Level'],
  ['clean', 'Expected'], ['elevation', 'Elevation'], ['instance', 'Instance'],
  ['class', 'Class'], ['shadow', 'In the shadow of'], ['multipath', 'Mirrored'],
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
    multipath: nameOf(frame.multipath),
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

// State of the page and the viewer of pings: which ping, what is shown of it, where the crosshair is.
//
// Events: ping (another one is wanted), frame (it is there), view (colours or overlays), marker, beam.

const state = {
  ping: 0, frame: null, quantity: 'level', map: 'inferno', limits: {},
  overlays: { instance: false, semantic: false, shadow: false, multipath: false }, opacity: 0.55,
  highlight: null,
  chosenBeam: null, playing: false,
};
const PLAY_MS = 120;
const QUANTITIES = { level: 'Level', clean: 'Expected', elevation: 'Elevation' };

let stage = null;
let readings = null;

function firstLimits(quantity) {
  const coding = codingOf(quantity);
  if (quantity === 'elevation') return { low: coding.min, high: coding.max };
  const { show_min_db: low, show_max_db: high } = report.scale;
  return { low: low === undefined ? coding.min : low, high: high === undefined ? coding.max : high };
}

function limitsOf(quantity) {
  const kind = quantity === 'elevation' ? 'elevation' : 'level';
  state.limits[kind] = state.limits[kind] || firstLimits(kind);
  return state.limits[kind];
}

function viewOf(quantity) {
  return { quantity, map: state.map, limits: limitsOf(quantity), coding: codingOf(quantity),
           overlays: state.overlays, opacity: state.opacity, highlight: state.highlight };
}

// What the ping has of what is asked for.
function shownQuantity() {
  const { codes } = state.frame;
  return codes[state.quantity] ? state.quantity : 'level';
}

function beamShown() {
  const { frame } = state;
  if (state.chosenBeam !== null) return clamp(state.chosenBeam, 0, frame.geometry.beams - 1);
  return frame.exact ? frame.exact.beam : frame.geometry.beams >> 1;
}

function goTo(index) {
  const wanted = clamp(index, 0, report.pings.length - 1);
  if (wanted === state.ping && state.frame) return;
  state.ping = wanted;
  emit('ping');
  followPing();
}

let following = false;

// One ping is decoded at a time, so that a slider that is drawn along shows what it passes.
async function followPing() {
  if (following) return;
  following = true;
  try {
    while (!state.frame || state.frame.index !== state.ping) {
      state.frame = await loadPing(state.ping);
      emit('frame');
    }
  } catch (error) {
    showNotice(`This picture cannot be shown: ${error.message}`);
  }
  following = false;
}

function redraw() {
  if (!state.frame) return;
  stage.beam = beamShown();
  stage.show(state.frame, viewOf(shownQuantity()));
}

function setPlaying(playing) {
  state.playing = playing;
  emit('ping');
  if (playing) playOn();
}

async function playOn() {
  while (state.playing) {
    const due = performance.now() + PLAY_MS;
    goTo((state.ping + 1) % report.pings.length);
    while (following) await new Promise((done) => setTimeout(done, 5));
    await new Promise((done) => setTimeout(done, Math.max(0, due - performance.now())));
  }
}

function showFacts() {
  const { record } = state.frame;
  const sequence = report.sequences[record.sequence];
  const parts = [`sequence ${sequence.sequence}`, `ping ${record.ping}`,
                 `${fixed(record.time_s, 2)} s`, record.split,
                 `${sequence.beams} beams × ${sequence.samples} samples`];
  byId('ping-facts').textContent = parts.filter(Boolean).join('  ·  ');
}

function showNotice(text) {
  byId('notice').hidden = false;
  byId('notice').textContent = text;
}

function markerMoved(spoken) {
  const reading = showReading(readings, state.frame, stage.marker);
  if (spoken) byId('live').textContent = spokenReading(reading);
  emit('marker');
}

function chooseBeam(beam) {
  state.chosenBeam = beam;
  emit('beam');
}

const PING_KEYS = {
  ArrowLeft: () => state.ping - 1, ArrowRight: () => state.ping + 1,
  PageUp: () => state.ping - 10, PageDown: () => state.ping + 10,
  Home: () => 0, End: () => report.pings.length - 1,
};

function isTyping(target) {
  return target.matches('select, textarea, input:not([type=checkbox]):not(#ping-slider)');
}

// Keys of the viewer; with the focus nowhere, left and right turn over pings too.
function listenToPingKeys() {
  const turn = (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || isTyping(event.target)) return;
    const next = PING_KEYS[event.key];
    if (!next || event.target.matches('input[type=radio]')) return;
    event.preventDefault();
    event.stopPropagation();
    goTo(next());
  };
  byId('viewer').addEventListener('keydown', turn);
  document.addEventListener('keydown', (event) => {
    const nowhere = event.target === document.body || event.target === byId('main');
    if (nowhere && event.key.startsWith('Arrow')) turn(event);
  });
}

const KEY_HELP = [
  ['← →', 'ping before, ping after'], ['Page Up, Page Down', 'ten pings'],
  ['Home, End', 'first ping, last ping'],
  ['in a picture: ← → ↑ ↓', 'move the crosshair; with Shift by ten'],
  ['in a picture: Enter', 'plot the beam under the crosshair'],
  ['in a picture: Esc', 'remove the crosshair'],
];

function startViewer() {
  readings = createReadout(READINGS);
  stage = createStage(byId('stage'), { onMark: markerMoved, onPick: chooseBeam });
  replace(byId('keys'), el('dl', { class: 'keys' }, ...KEY_HELP.map(
      ([keys, what]) => el('div', {}, el('dt', { text: keys }), el('dd', { text: what })))));
  on('frame', () => {
    showFacts();
    redraw();
    showReading(readings, state.frame, stage.marker);
  });
  on('view', redraw);
  on('beam', () => {
    stage.beam = beamShown();
    stage.redrawOver();
  });
  listenToPingKeys();
}
