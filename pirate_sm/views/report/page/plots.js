// Measurements over time, by uPlot; one part of the run is visible in all of them.

const DASHES = [[], [7, 3], [2, 2], [9, 3, 2, 3]], OTHER = [3, 3];
const TINTS = 8, HEIGHT = 200;

/** A value that is older than this shows its age, s. */
const OLD_S = 0.5;

const BAND_ALPHA = 0.16;

const drawPlots = () => {
  const host = byId('plots');
  let plots = [], pointed = null;

  /** Curves that were measured at different times on one axis; uPlot knows gaps from misses. */
  const aligned = (series) => {
    const tables = series.map((each) => [clocks[each.clock], each.values]);
    return uPlot.join(tables);
  };

  /** A curve to be compared with another one has its colour, and other dashes. */
  const styleOf = (series, own) => {
    const isOther = series[own].like !== undefined, number = isOther ? series[own].like : own;
    const dash = isOther ? OTHER : series.some((each) => each.like !== undefined) ? [] : DASHES[(number + Math.floor(number / TINTS)) % DASHES.length];
    return { tint: `--curve${number % TINTS}`, dash };
  };

  const swatch = (all, number) => {
    const { tint, dash } = styleOf(all, number);
    const drawing = element('svg', { width: 26, height: 10, 'aria-hidden': 'true' });
    drawing.append(element('line', {
      x1: 1, x2: 25, y1: 5, y2: 5, style: `stroke: var(${tint})`, 'stroke-width': 2.5, 'stroke-dasharray': dash.join(' '),
    }));
    return drawing;
  };

  const legend = (chart, figure, plotOf) => {
    const list = document.createElement('ul');
    list.className = 'legend';
    const values = chart.series.map((series, number) => {
      const item = document.createElement('li'), button = document.createElement('button');
      const value = document.createElement('span');
      value.className = 'value';
      button.type = 'button';
      button.setAttribute('aria-pressed', 'true');
      button.title = 'Show or hide this curve';
      button.append(swatch(chart.series, number), document.createTextNode(series.name), value);
      button.addEventListener('click', () => {
        const on = button.getAttribute('aria-pressed') !== 'true';
        button.setAttribute('aria-pressed', String(on));
        plotOf().setSeries(number + 1, { show: on });
      });
      button.addEventListener('pointerenter', () => { pointed = series; plotOf().setSeries(number + 1, { focus: true }); });
      button.addEventListener('pointerleave', () => { pointed = null; plotOf().setSeries(null, { focus: true }); });
      item.append(button);
      list.append(item);
      return value;
    });
    if (chart.bands) {
      const item = document.createElement('li');
      item.className = 'band';
      item.textContent = chart.bands;
      list.append(item);
    }
    figure.append(list);
    return () => chart.series.forEach((series, number) => {
      const value = valueAt(series, shown.at), age = ageAt(series, shown.at);
      const old = data.running && !series.stepped && age > OLD_S ? ` ${timeText(age)} ago` : '';
      values[number].textContent = value === null ? '–' : value.toFixed(chart.digits) + old;
    });
  };

  /** The bands of the curves that are shown: from when until when, between which values. */
  const bandsIn = (chart, plot) => chart.series.flatMap((series, number) => {
    const { band } = series;
    if (!band || !plot.series[number + 1].show) return [];
    const times = clocks[band.clock], { tint } = styleOf(chart.series, number), boxes = [];
    for (let i = 0; i + 1 < times.length; i++) {
      if (band.low[i] === null || times[i + 1] <= shown.from || times[i] >= shown.to) continue;
      boxes.push([Math.max(times[i], shown.from), Math.min(times[i + 1], shown.to), band.low[i], band.high[i]]);
    }
    return boxes.length ? [{ series, tint, boxes }] : [];
  });

  /** Bands are behind their curves; while one is pointed at in the legend, the others are away. */
  const drawBands = (chart) => (plot) => {
    const { ctx } = plot, x = (time) => Math.round(plot.valToPos(time, 'x', true)), y = (value) => plot.valToPos(value, 'y', true);
    ctx.save();
    ctx.globalAlpha = BAND_ALPHA;
    bandsIn(chart, plot).forEach(({ series, tint, boxes }) => {
      if (pointed !== null && chart.series.includes(pointed) && series !== pointed) return;
      ctx.fillStyle = colour(tint);
      ctx.beginPath();
      boxes.forEach(([from, until, low, high]) => ctx.rect(x(from), y(high) - 1, x(until) - x(from), y(low) - y(high) + 2));
      ctx.fill();
    });
    ctx.restore();
  };

  /** The axis of values has room for the bands too. */
  const withBands = (chart) => (plot, low, high) => {
    const bounds = [low, high].filter((each) => each !== null);
    bandsIn(chart, plot).forEach(({ boxes }) => boxes.forEach((box) => bounds.push(box[2], box[3])));
    if (!bounds.length) return [low, high];
    const [least, most] = bounds.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    return uPlot.rangeNum(least, most, 0.1, true);
  };

  const optionsOf = (chart, width) => {
    const axis = {
      stroke: colour('--soft'), font: '12px system-ui, sans-serif',
      grid: { stroke: colour('--grid'), width: 1 }, ticks: { stroke: colour('--grid'), width: 1 },
    };
    return {
      width,
      height: HEIGHT,
      legend: { show: false },
      padding: [8, 18, 0, 0],
      focus: { alpha: 0.25 },
      cursor: {
        y: false, points: { show: false }, focus: { prox: -1 }, drag: { x: true, y: false, setScale: false },
      },
      scales: {
        x: { time: false, range: () => [shown.from, shown.to] },
        ...(chart.bands ? { y: { range: withBands(chart) } } : {}),
      },
      axes: [
        { ...axis, size: 30, incrs: STEPS, values: (_, ticks) => ticks.map(ticked) },
        { ...axis, size: 58, values: (_, ticks) => ticks.map((each) => `${+each.toFixed(6)}`) },
      ],
      series: [{}, ...chart.series.map((series, number) => {
        const { tint, dash } = styleOf(chart.series, number);
        return {
          label: series.name, stroke: colour(tint), dash, width: series.main ? 2.5 : 1.6,
          points: { show: false },
          paths: series.stepped ? uPlot.paths.stepped({ align: 1 }) : uPlot.paths.linear(),
        };
      })],
      hooks: {
        drawAxes: [drawBands(chart)],
        draw: [({ ctx, bbox, valToPos }) => {
          const end = bbox.left + bbox.width, at = (time) => Math.min(end, Math.max(bbox.left, valToPos(time, 'x', true)));
          ctx.save();
          ctx.globalAlpha = 0.3;
          ctx.fillStyle = colour('--soft');
          data.gaps.forEach(([from, until]) => {
            if (until < shown.from || from > shown.to) return;
            ctx.fillRect(at(from), bbox.top, Math.max(2, at(until) - at(from)), bbox.height);
          });
          ctx.restore();
        }],
        setSelect: [(plot) => {
          const { left, width: wide } = plot.select;
          if (wide < 4) return;
          plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          shown.zoom(plot.posToVal(left, 'x'), plot.posToVal(left + wide, 'x'));
        }],
      },
    };
  };

  const listen = (plot) => {
    const area = plot.root.querySelector('.u-over') || plot.over;
    const point = (event) => {
      const box = area.getBoundingClientRect();
      shown.goTo(Math.min(shown.to, Math.max(shown.from, plot.posToVal(event.clientX - box.left, 'x'))));
    };
    area.addEventListener('mousemove', (event) => {
      if (!player.playing && !player.following && !event.buttons) point(event);
    });
    area.addEventListener('click', point);
    area.addEventListener('mouseleave', () => requestAnimationFrame(() => place(plot)));
    area.addEventListener('dblclick', () => shown.whole());
  };

  const place = (plot) => {
    const inside = shown.at >= shown.from && shown.at <= shown.to;
    plot.setCursor({ left: inside ? plot.valToPos(shown.at, 'x') : -10, top: 0 });
  };

  /** A plot for those who do not see it: between which values each curve runs. */
  const inWords = (chart) => {
    const ranges = chart.series.map(({ name, values }) => {
      const known = values.filter((value) => value !== null);
      if (!known.length) return `${name} unknown`;
      const [low, high] = known.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
      return `${name} from ${low.toFixed(chart.digits)} to ${high.toFixed(chart.digits)}`;
    });
    const bands = chart.bands ? `; ${chart.bands}` : '';
    return `${chart.title} in ${chart.unit} over time: ${ranges.join('; ')}${bands}`;
  };

  const make = (chart) => {
    const figure = document.createElement('figure'), caption = document.createElement('figcaption');
    const title = document.createElement('strong'), area = document.createElement('div');
    area.setAttribute('role', 'img');
    area.setAttribute('aria-label', inWords(chart));
    title.textContent = chart.title;
    caption.append(title, ` in ${chart.unit} `);
    if (chart.note) {
      const note = document.createElement('small');
      note.textContent = chart.note;
      caption.append(note);
    }
    figure.append(caption);
    host.append(figure);
    const made = { plot: null, area, update: null, table: aligned(chart.series), stale: false };
    made.update = legend(chart, figure, () => made.plot);
    figure.append(area);
    made.build = () => {
      const hidden = made.plot ? made.plot.series.map((each) => !each.show) : [];
      if (made.plot) made.plot.destroy();
      made.plot = new uPlot(optionsOf(chart, area.clientWidth || 300), made.table, area);
      hidden.forEach((each, number) => { if (number && each) made.plot.setSeries(number, { show: false }); });
      listen(made.plot);
      place(made.plot);
      made.update();
    };
    made.build();
    made.grow = () => {
      made.table = aligned(chart.series);
      made.plot.setData(made.table);
      area.setAttribute('aria-label', inWords(chart));
    };
    new ResizeObserver(() => {
      if (area.clientWidth && area.clientWidth !== made.plot.width) made.plot.setSize({ width: area.clientWidth, height: HEIGHT });
      place(made.plot);
    }).observe(area);
    plots.push(made);
  };

  const names = () => JSON.stringify(data.charts.map((chart) => [chart.title, chart.note, chart.bands, chart.series.map((each) => each.name)]));
  let drawn = '';
  const fill = () => {
    if (drawn === names()) { plots.forEach((each) => each.grow()); return; }
    drawn = names();
    plots.forEach(({ plot }) => plot.destroy());
    plots = [];
    host.replaceChildren();
    data.charts.forEach(make);
  };
  fill();
  shown.on('data', fill);
  shown.on('time', () => plots.forEach(({ plot, update }) => { place(plot); update(); }));
  shown.on('range', () => plots.forEach(({ plot }) => {
    plot.setScale('x', { min: shown.from, max: shown.to });
    place(plot);
  }));
  shown.on('size', () => plots.forEach(({ build }) => build()));
};
