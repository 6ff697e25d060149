// SPDX-License-Identifier: Apache-2.0
// Tables and forms of the scope. Text goes in as text, never as HTML.
'use strict';

const $ = id => document.getElementById(id);
const shown = value => value === null || value === undefined ? '–' : Number(value.toPrecision(7)).toString();

function row(cells, tag = 'td') {
  const line = document.createElement('tr');
  for (const cell of cells) {
    const made = document.createElement(tag);
    made.append(cell instanceof Node ? cell : document.createTextNode(cell));
    line.append(made);
  }
  return line;
}

function options(select, names, chosen) {
  select.replaceChildren(...names.map(name => new Option(name, name, false, name === chosen)));
}

function buildChannels(channels, chosen, changed) {
  const groups = {};
  for (const channel of channels) (groups[channel.group] ||= []).push(channel);
  $('channels').replaceChildren(...Object.entries(groups).flatMap(([group, list]) => {
    const head = document.createElement('h3');
    head.textContent = group;
    return [head, ...list.map(channel => {
      const label = document.createElement('label'), box = document.createElement('input');
      Object.assign(box, {type: 'checkbox', value: channel.name, checked: chosen.includes(channel.name)});
      box.addEventListener('change', () => changed(channel.name, box.checked));
      label.append(box, ` ${channel.name} [${channel.unit || '1'}]`);
      label.title = channel.meaning;
      return label;
    })];
  }));
  $('filter').addEventListener('input', () => {
    for (const label of $('channels').querySelectorAll('label')) {
      label.hidden = !label.textContent.toLowerCase().includes($('filter').value.toLowerCase());
      label.style.display = label.hidden ? 'none' : '';
    }
  });
}

function buildGains(gains, stage) {
  $('gains').replaceChildren(row(['gain', 'in use', 'next', 'unit'], 'th'), ...gains.map(gain => {
    const input = document.createElement('input');
    Object.assign(input, {type: 'number', step: 'any'});
    input.setAttribute('aria-label', gain.name);
    input.addEventListener('change', () => stage(gain.name, input.value === '' ? null : Number(input.value)));
    const line = row([gain.name, shown(gain.value), input, gain.unit]);
    line.dataset.gain = gain.name;
    line.title = `${gain.form}: ${gain.meaning}`;
    return line;
  }));
}

function showGains(state) {
  for (const line of $('gains').querySelectorAll('tr[data-gain]')) {
    const name = line.dataset.gain, staged = name in state.staged, input = line.querySelector('input');
    line.children[1].textContent = shown(state.gains[name]);
    line.classList.toggle('staged', staged);
    if (document.activeElement !== input) input.value = staged ? state.staged[name] : '';
  }
  const waiting = Object.keys(state.staged).length;
  $('commit').textContent = waiting ? `Commit ${waiting} together` : 'Commit';
  $('commit').disabled = $('discard').disabled = !waiting;
  $('version').textContent = `version ${state.version}` + (state.committed > state.version ? ', next on its way' : '');
}

function showTrigger(form, state) {
  const {settings} = state.trigger;
  $('trigger-state').textContent = state.trigger.state;
  if (form.contains(document.activeElement)) return;
  for (const [name, value] of Object.entries(settings)) {
    if (name !== 'channel' || value) form.elements[name].value = name === 'pre' ? 100 * value : value;
  }
  fitTrigger(form);
}

// Only the fields that the kind of trigger has.
function fitTrigger(form) {
  const kind = form.elements.kind.value;
  for (const label of form.querySelectorAll('.edge')) label.hidden = !['rising', 'falling'].includes(kind);
  for (const label of form.querySelectorAll('.area')) label.hidden = !['leave', 'enter'].includes(kind);
  for (const label of form.querySelectorAll('.edge, .area')) label.style.display = label.hidden ? 'none' : '';
}

function triggerSettings(form) {
  const field = name => form.elements[name], number = name => Number(field(name).value || 0);
  return {
    mode: field('mode').value, kind: field('kind').value, channel: field('channel').value,
    level: number('level'), low: number('low'), high: number('high'),
    pre: number('pre') / 100, span: Math.round(number('span')),
  };
}

function showCursors(reply, period, channels) {
  const span = (reply.b - reply.a) * period;
  const head = ['channel', `A: tick ${reply.a}`, `B: tick ${reply.b}`, 'B - A', 'unit'];
  const names = Object.keys(reply.at_a || reply.at_b || {});
  const cell = (values, name) => values ? shown(values[name]) : 'not kept';
  $('cursors').replaceChildren(row(head, 'th'),
    row(['time', '', '', shown(span), span ? `s, ${shown(1 / span)} Hz` : 's']),
    ...names.map(name => row([name, cell(reply.at_a, name), cell(reply.at_b, name),
      reply.at_a && reply.at_b ? shown(reply.at_b[name] - reply.at_a[name]) : '', channels[name].unit])));
  $('cursors').hidden = false;
}

function showFigures(responses) {
  const ms = value => value === null ? '–' : `${(value * 1e3).toPrecision(4)} ms`;
  const percent = value => `${(value * 100).toPrecision(4)} %`;
  $('figures').replaceChildren(
    row(['step', 'gains', 'rise 10–90 %', 'overshoot', 'peak', 'settled ±2 %', 'final'], 'th'),
    ...responses.map(({name, version, figures: f}) => row([`${name} ${shown(f.amplitude)}`, version,
      ms(f.rise), percent(f.overshoot), ms(f.peak), ms(f.settling), percent(f.final)])).reverse());
}

function showLastTicks(box) {
  $('last-ticks').replaceChildren(row(['tick', ...box.ticks], 'th'),
    ...Object.entries(box.values).map(([name, values]) => row([name, ...values])));
}
