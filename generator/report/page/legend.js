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
