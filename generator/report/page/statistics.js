// Data sets without pings: pictures of the statistics of their sequences, in the viewer's place.

const statisticsState = { entry: 0, array: 0, frame: null, limits: {} };
const STATISTICS_READINGS = [['range', 'Slant range'], ['azimuth', 'Azimuth'],
                             ['cell', 'Beam, sample'], ['value', 'Value']];
const MOST_SPECKLE = 2;  // upper limit of contrast at first: developed speckle has 1

function statisticsEntry() {
  return report.statistics[statisticsState.entry];
}

function statisticsArray() {
  return statisticsEntry().arrays[statisticsState.array];
}

function statisticsCoding() {
  const { min, max } = statisticsArray();
  return { min, max: max > min ? max : min + 1, empty: 'none' };
}

function statisticsUnit() {
  const { unit } = statisticsArray();
  return unit && unit !== '1' ? unit : '';
}

const statisticsLimits = {
  ready: () => Boolean(statisticsState.frame),
  coding: statisticsCoding,
  unit: statisticsUnit,
  limits: () => {
    const { name } = statisticsArray();
    const coding = statisticsCoding();
    const high = name === 'contrast' && coding.min < MOST_SPECKLE ? Math.min(coding.max, MOST_SPECKLE)
                                                                   : coding.max;
    return statisticsState.limits[name] || { low: coding.min, high };
  },
  set: (limits) => {
    statisticsState.limits[statisticsArray().name] = limits;
  },
};

async function loadStatistics() {
  const entry = statisticsEntry();
  const array = statisticsArray();
  const sequence = report.sequences.find((other) => other.sequence === entry.sequence) ||
      report.sequences[entry.sequence];
  const codes = await greyCodes(array.chunk, sequence, false);
  if (entry !== statisticsEntry() || array !== statisticsArray()) return;
  statisticsState.frame = { sequence, geometry: geometryOf(sequence), codes: { [array.name]: codes } };
  byId('ping-facts').textContent = [`sequence ${entry.sequence}`,
                                    plural(entry.realisations, 'realisation'), array.what]
      .filter(Boolean).join('  ·  ');
  showSequence(sequence);
  emit('frame');
}

function drawStatistics() {
  if (!statisticsState.frame || !(statisticsArray().name in statisticsState.frame.codes)) return;
  stage.show(statisticsState.frame, {
    quantity: statisticsArray().name, map: state.map, limits: statisticsLimits.limits(),
    coding: statisticsCoding(), overlays: {}, opacity: 0, highlight: null });
}

function readStatistics(spoken) {
  const { frame } = statisticsState;
  const cell = stage.marker;
  let reading = null;
  if (frame && cell) {
    const code = frame.codes[statisticsArray().name][cell.sample * frame.geometry.beams + cell.beam];
    reading = readAt({ ...frame, codes: {} }, cell);
    reading.value = code ? `${brief(decode(code, statisticsCoding()))} ${statisticsUnit()}`.trim()
                         : 'none';
  }
  writeReading(readings, reading);
  if (spoken && reading) {
    byId('live').textContent =
        `Range ${reading.range}, azimuth ${reading.azimuth}, value ${reading.value}.`;
  }
}

function statisticsChoices() {
  const names = statisticsEntry().arrays.map(({ name }, k) => ({
    value: String(k), text: name.replaceAll('_', ' '), has: true, checked: k === 0,
    act: (value) => {
      statisticsState.array = Number(value);
      loadStatistics();
    },
  }));
  return choiceGroup('Statistic', 'radio', 'statistic', names);
}

function statisticsTransport() {
  const last = report.statistics.length - 1;
  if (last === 0) return;
  const place = el('output', { class: 'place', for: 'ping-slider' });
  const slider = el('input', {
    type: 'range', id: 'ping-slider', min: 0, max: last, step: 1, value: 0, 'aria-label': 'Sequence',
    oninput: () => {
      statisticsState.entry = Number(slider.value);
      place.textContent = `${statisticsState.entry + 1} / ${last + 1}`;
      loadStatistics();
    },
  });
  place.textContent = `1 / ${last + 1}`;
  replace(byId('transport'), slider, place);
}

function startStatistics() {
  byId('viewer-title').textContent = 'Statistics';
  readings = createReadout(STATISTICS_READINGS);
  stage = createStage(byId('stage'), { onMark: readStatistics, onPick: () => {} });
  on('frame', drawStatistics);
  on('view', drawStatistics);
  replace(byId('side'), statisticsChoices(),
          el('fieldset', { class: 'colours' }, el('legend', { text: 'Colours' }), mapChoice(),
             limitControls(statisticsLimits)));
  statisticsTransport();
  byId('viewer').querySelector('.help').hidden = true;
  loadStatistics().catch((error) => showNotice(`This picture cannot be shown: ${error.message}`));
}
