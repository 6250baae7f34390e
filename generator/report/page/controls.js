// Controls of the viewer: transport, what is shown, colours and limits.

function button(title, content, act, more = {}) {
  return el('button', { type: 'button', title, 'aria-label': title, onclick: act, ...more }, content);
}

const ICONS = {
  first: 'M4 3v10M13 3L6.5 8l6.5 5z', before: 'M10.5 3L4.5 8l6 5z', after: 'M5.5 3l6 5-6 5z',
  last: 'M12 3v10M3 3l6.5 5L3 13z', play: 'M5 3l8 5-8 5z', pause: 'M5.5 3.5v9M10.5 3.5v9',
};

function icon(name) {
  return svg('svg', { class: 'icon', viewBox: '0 0 16 16', width: 16, height: 16,
                      'aria-hidden': 'true' }, svg('path', { d: ICONS[name] }));
}

function createTransport() {
  const last = report.pings.length - 1;
  const slider = el('input', {
    type: 'range', id: 'ping-slider', min: 0, max: last, step: 1, value: 0, 'aria-label': 'Ping',
    oninput: () => goTo(Number(slider.value)),
  });
  const place = el('output', { class: 'place', for: 'ping-slider' });
  const play = button('Play', icon('play'), () => setPlaying(!state.playing), { class: 'play' });
  replace(byId('transport'),
          el('div', { class: 'buttons', role: 'group', 'aria-label': 'Turn over pings' },
             button('First ping', icon('first'), () => goTo(0)),
             button('Ping before', icon('before'), () => goTo(state.ping - 1)), play,
             button('Ping after', icon('after'), () => goTo(state.ping + 1)),
             button('Last ping', icon('last'), () => goTo(last))),
          slider, place);
  on('ping', () => {
    slider.value = state.ping;
    slider.setAttribute('aria-valuetext', `${state.ping + 1} of ${last + 1}`);
    place.textContent = `${whole(state.ping + 1)} / ${whole(last + 1)}`;
    replace(play, icon(state.playing ? 'pause' : 'play'));
    play.setAttribute('aria-label', state.playing ? 'Pause' : 'Play');
    play.title = state.playing ? 'Pause' : 'Play';
  });
}

// A group of choices; those that no ping has are shown, out of reach, with the reason.
function choiceGroup(title, type, name, choices) {
  const items = choices.map(({ value, text, has, checked, act }) => {
    const input = el('input', { type, name, value, checked, disabled: !has,
                                onchange: () => act(value, input.checked) });
    return el('label', { class: has ? 'choice' : 'choice missing',
                         title: has ? null : 'not in this data set' }, input,
              el('span', { text }), has ? null : el('small', { text: 'not in the data set' }));
  });
  return el('fieldset', { class: `choices ${type}s` }, el('legend', { text: title }), ...items);
}

function hasPicture(name) {
  return report.pings.some(({ pictures }) => pictures && Number.isInteger(pictures[name]));
}

function pictureChoices() {
  const choices = Object.entries(QUANTITIES).map(([value, text]) => ({
    value, text, has: value === 'level' || hasPicture(value), checked: value === 'level',
    act: () => {
      state.quantity = value;
      emit('view');
    },
  }));
  return choiceGroup('Picture', 'radio', 'quantity', choices);
}

function overlayChoices() {
  const overlays = [['instance', 'Instances', 'labels'], ['semantic', 'Classes', 'labels'],
                    ['shadow', 'Shadows', 'shadow'], ['multipath', 'Mirrored', 'multipath']];
  const group = choiceGroup('Overlays', 'checkbox', 'overlay', overlays.map(
      ([value, text, picture]) => ({
        value, text, has: hasPicture(picture), checked: false,
        act: (name, checked) => {
          state.overlays[name] = checked;
          emit('view');
        },
      })));
  const opacity = el('input', {
    type: 'range', id: 'opacity', min: 0.1, max: 1, step: 0.05, value: state.opacity,
    oninput: () => {
      state.opacity = Number(opacity.value);
      emit('view');
    },
  });
  group.append(el('label', { class: 'opacity' }, el('span', { text: 'Opacity' }), opacity));
  return group;
}

// The colour bar spans all that pictures hold; two thumbs on it are the limits of display.
// source: {coding(), limits(), set(limits or null), unit(), ready()}
function limitControls(source) {
  const bar = el('canvas', { class: 'bar', width: 512, height: 1, 'aria-hidden': 'true' });
  const scale = el('div', { class: 'bar-scale', 'aria-hidden': 'true' });
  const make = (side, name, type) => el('input', {
    type, class: `limit ${side}`, id: `${side}-${type}`, step: 'any', 'aria-label': name,
    oninput: (event) => event.target.value !== '' &&
        setLimit(source, side, Number(event.target.value)),
  });
  const controls = {
    bar, scale,
    low: [make('low', 'Lower limit', 'range'), make('low', 'Lower limit', 'number')],
    high: [make('high', 'Upper limit', 'range'), make('high', 'Upper limit', 'number')],
    unit: el('span', { class: 'unit' }),
  };
  const reset = button('First limits again', 'Reset', () => {
    source.set(null);
    emit('view');
  }, { class: 'quiet' });
  const box = el('div', { class: 'limits' },
                 el('div', { class: 'bar-box' }, bar, controls.low[0], controls.high[0]), scale,
                 el('div', { class: 'limit-numbers' }, controls.low[1], el('span', { text: 'to' }),
                    controls.high[1], controls.unit, reset));
  const refresh = () => source.ready() && showLimits(controls, source);
  on('view', refresh);
  on('frame', refresh);
  return box;
}

function setLimit(source, side, value) {
  if (!Number.isFinite(value)) return;
  const { min, max } = source.coding();
  const limits = { ...source.limits() };
  const least = (max - min) / 200;
  if (side === 'low') limits.low = clamp(value, min, Math.min(max, limits.high) - least);
  else limits.high = clamp(value, Math.max(min, limits.low) + least, max);
  source.set(limits);
  emit('view');
}

function showLimits(controls, source) {
  const coding = source.coding();
  const limits = source.limits();
  const digits = coding.max - coding.min > 20 ? 1 : 3;
  for (const side of ['low', 'high']) {
    for (const input of controls[side]) {
      input.min = coding.min;
      input.max = coding.max;
      input.step = input.type === 'range' ? (coding.max - coding.min) / 240 : 10 ** -digits;
      if (input.type === 'number') input.step = 'any';
      if (document.activeElement !== input || input.type === 'range') {
        input.value = Number(limits[side].toFixed(digits));
      }
    }
  }
  controls.unit.textContent = source.unit();
  drawBar(controls, coding, limits);
}

function drawBar({ bar, scale }, coding, limits) {
  const context = bar.getContext('2d', { willReadFrequently: true });
  const image = context.createImageData(bar.width, 1);
  const pixels = new Uint32Array(image.data.buffer);
  const map = mapTable(state.map);
  for (let k = 0; k < bar.width; ++k) {
    const value = coding.min + (k / (bar.width - 1)) * (coding.max - coding.min);
    const share = (value - limits.low) / (limits.high - limits.low);
    pixels[k] = map[clamp(Math.round(share * 255), 0, 255)];
  }
  context.putImageData(image, 0, 0);
  const marks = ticks(coding.min, coding.max, 5).map((value) => {
    const mark = el('span', { text: tickText(value) });
    mark.style.left = `${((value - coding.min) / (coding.max - coding.min)) * 100}%`;
    return mark;
  });
  replace(scale, ...marks);
}

function mapChoice() {
  const select = el('select', {
    id: 'map', onchange: () => {
      state.map = select.value;
      emit('view');
    },
  }, ...MAP_NAMES.map((name) => el('option', { value: name, text: name,
                                               selected: name === state.map })));
  return el('label', { class: 'field' }, el('span', { text: 'Colour map' }), select);
}

const pingLimits = {
  ready: () => Boolean(state.frame),
  coding: () => codingOf(shownQuantity()),
  limits: () => limitsOf(shownQuantity()),
  unit: () => (shownQuantity() === 'elevation' ? '°' : 'dB'),
  set: (limits) => {
    state.limits[shownQuantity() === 'elevation' ? 'elevation' : 'level'] = limits;
  },
};

function createControls() {
  createTransport();
  replace(byId('side'), pictureChoices(), overlayChoices(),
          el('fieldset', { class: 'colours' }, el('legend', { text: 'Colours' }), mapChoice(),
             limitControls(pingLimits)));
  createLegend(byId('legend'));
}

// Names and colours of classes and instances; choosing one lets the rest of the picture go dim.

const MOST_NAMES = 60;

function createLegend(container) {
  const classes = el('div', { class: 'chips', role: 'group', 'aria-label': 'Classes' });
  const instances = el('div', { class: 'names', role: 'group', 'aria-label': 'Instances' });
  const hint = el('p', { class: 'hint' });
  replace(container,
          el('div', { class: 'legend-part' }, el('h3', { text: 'Classes' }), classes),
          el('div', { class: 'legend-part' }, el('h3', { text: 'Instances in this ping' }), instances,
             hint));
  on('frame', () => {
    replace(classes, ...report.classes.map((name, k) => legendButton('class', k + 1, name)));
    showInstances(instances, hint);
    showPressed(container);
  });
  on('view', () => showPressed(container));
  container.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || !state.highlight) return;
    state.highlight = null;
    emit('view');
  });
}

function legendButton(kind, id, name, note) {
  const swatch = el('span', { class: 'swatch', 'aria-hidden': 'true' });
  swatch.style.backgroundColor = cssColour(kind === 'class' ? classColour(id) : nameColour(id));
  return el('button', {
    type: 'button', class: `name of-${kind}`, 'aria-pressed': 'false', 'data-kind': kind,
    'data-id': id, onclick: () => toggleHighlight(kind, id),
  }, swatch, el('span', { class: 'name-text', text: name }),
            note ? el('span', { class: 'name-note', text: note }) : null);
}

function toggleHighlight(kind, id) {
  const { highlight } = state;
  const same = highlight && highlight.kind === kind && highlight.id === id;
  state.highlight = same ? null : { kind, id };
  emit('view');
}

function showPressed(container) {
  const { highlight } = state;
  for (const item of container.querySelectorAll('button.name')) {
    const pressed = highlight && highlight.kind === item.dataset.kind &&
        highlight.id === Number(item.dataset.id);
    item.setAttribute('aria-pressed', pressed ? 'true' : 'false');
  }
}

function seenNote(instance, pixels, occlusion) {
  const parts = [instance ? instance.class : '', `${whole(pixels)} px`];
  if (Number.isFinite(occlusion) && occlusion >= 0.005) {
    parts.push(`${Math.round(occlusion * 100)} % hidden`);
  }
  return parts.filter(Boolean).join(', ');
}

function showInstances(container, hint) {
  const { sequence, record } = state.frame;
  const seen = [...(record.seen || [])].sort((a, b) => b[1] - a[1]);
  const items = seen.slice(0, MOST_NAMES).map(([id, pixels, occlusion]) => legendButton(
      'instance', id, instanceName(sequence, id),
      seenNote(instanceOf(sequence, id), pixels, occlusion)));
  replace(container, ...items);
  if (!state.frame.instance && seen.length === 0) {
    hint.textContent = 'The data set has no masks.';
    return;
  }
  const unseen = (sequence.instances || []).length - seen.length;
  const notes = [];
  if (seen.length > MOST_NAMES) notes.push(`${seen.length - MOST_NAMES} more in this ping.`);
  if (unseen > 0) notes.push(`${plural(unseen, 'instance')} of the sequence not seen in this ping.`);
  if (seen.length === 0 && unseen <= 0) notes.push('None.');
  hint.textContent = notes.join(' ');
}
