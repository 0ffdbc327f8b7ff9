// The pictures of a page of `seidel view`: PSFs over the field from a precomputed atlas, or the gap of a report by zone.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const field = document.getElementById("field"), chosen = document.getElementById("chosen");
  const pen = field.getContext("2d"), close = chosen.getContext("2d");
  const where = document.getElementById("where"), form = document.getElementById("controls");
  const controls = {};
  let picked = 0;

  // Adds a slider whose positions have names, and calls `change` when it moves.
  function slider(id, label, names, start) {
    const box = document.createElement("div"), text = document.createElement("label");
    const out = document.createElement("output"), input = document.createElement("input");
    box.className = "control";
    Object.assign(input, { type: "range", min: 0, max: names.length - 1, step: 1, value: start, id });
    text.htmlFor = id;
    text.append(label, out);
    const name = () => { out.textContent = names[input.value]; input.setAttribute("aria-valuetext", names[input.value]); };
    input.addEventListener("input", () => { name(); draw(); });
    name();
    box.append(text, input);
    if (names.length > 1) form.append(box);
    controls[id] = { get at() { return Number(input.value); }, get name() { return names[input.value]; } };
  }

  // Adds a check box.
  function check(id, label, on) {
    const box = document.createElement("div"), text = document.createElement("label");
    const input = document.createElement("input");
    box.className = "control check";
    Object.assign(input, { type: "checkbox", checked: on, id });
    text.append(input, label);
    input.addEventListener("change", () => draw());
    box.append(text);
    form.append(box);
    controls[id] = { get on() { return input.checked; } };
  }

  function clear(pen, canvas) {
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.fillStyle = "#05070a";
    pen.fillRect(0, 0, canvas.width, canvas.height);
  }

  // A bar of a round number of frame pixels, `scale` canvas pixels each, and its label.
  function scaleBar(pen, canvas, scale, letters) {
    const most = 0.2 * canvas.width / scale;
    const decade = 10 ** Math.floor(Math.log10(most));
    const length = decade * [5, 2, 1].find(step => step * decade <= most);
    const left = 16, y = canvas.height - 18;
    pen.strokeStyle = pen.fillStyle = "#c8d0d8";
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(left, y - 5); pen.lineTo(left, y); pen.lineTo(left + length * scale, y); pen.lineTo(left + length * scale, y - 5);
    pen.stroke();
    pen.font = `${letters}px system-ui, sans-serif`;
    pen.fillText(`${Number(length.toPrecision(2))} px`, left, y - 10);
  }

  // The frame of the lens on the canvas: canvas pixels per frame pixel, and the place of a frame point.
  const margin = 56;
  const [wide, high] = data.frame || [16, 9];
  field.height = Math.round((field.width - 2 * margin) * high / wide) + 2 * margin;
  const frameScale = (field.width - 2 * margin) / wide;
  const onCanvas = (x, y) => [margin + x * frameScale, margin + y * frameScale];

  function outline() {
    pen.strokeStyle = "#3a444f";
    pen.lineWidth = 1;
    pen.strokeRect(margin, margin, wide * frameScale, high * frameScale);
    const [x, y] = onCanvas(...data.axis);
    pen.beginPath();
    pen.moveTo(x - 7, y); pen.lineTo(x + 7, y); pen.moveTo(x, y - 7); pen.lineTo(x, y + 7);
    pen.stroke();
  }

  // ---- PSFs ----

  const atlas = new Image();

  // Draws tile `tile` of the atlas centred on (x, y) with side `size`, turned by `angle` and mirrored by the signs.
  function drawTile(pen, { tile, angle, mirror }, x, y, size) {
    const side = data.atlas.side, column = tile % data.atlas.columns, row = Math.floor(tile / data.atlas.columns);
    pen.save();
    pen.translate(x, y);
    pen.rotate(angle || 0);
    pen.scale(...(mirror || [1, 1]));
    pen.globalCompositeOperation = "lighter";
    pen.imageSmoothingEnabled = true;
    pen.imageSmoothingQuality = "high";
    pen.drawImage(atlas, column * side, row * side, side, side, -size / 2, -size / 2, size, size);
    pen.restore();
  }

  // The tile of a lens at field radius number `ring` and azimuth `turn`, radians.
  function polarTile(state, ring, turn) {
    const { rings, azimuths, symmetry } = data.polar, perState = 1 + (rings.length - 1) * azimuths.length;
    const at = azimuth => state * perState + (ring === 0 ? 0 : 1 + (ring - 1) * azimuths.length + azimuth);
    if (symmetry === "round") return { tile: at(0), angle: turn };
    const degrees = ((turn * 180 / Math.PI + 1e-6) % 360 + 360) % 360, step = data.polar.step_deg;
    if (symmetry === "none") return { tile: at(Math.round(degrees / step) % azimuths.length) };
    const folded = degrees <= 90 ? degrees : degrees <= 180 ? 180 - degrees : degrees <= 270 ? degrees - 180 : 360 - degrees;
    const mirror = [degrees > 90 && degrees < 270 ? -1 : 1, degrees > 180 ? -1 : 1];
    return { tile: at(Math.round(folded / step)), mirror };
  }

  // The PSFs of the chosen state: place in the frame, tile and words of each.
  function places() {
    const state = controls.distance.at * data.stops.length + controls.stop.at;
    if (!data.polar) return data.states[state].points.map(point => ({
      at: point.at, tiles: point.tiles.map(tile => ({ tile })),
      words: `${point.name}: x ${point.at[0].toFixed(0)}, y ${point.at[1].toFixed(0)} px`,
    }));
    const list = [], half = wide / 2, spokes = 8, turn = controls.turn.at * data.polar.step_deg;
    data.polar.rings.forEach((radius, ring) => {
      for (let spoke = 0; spoke < (ring ? spokes : 1); spoke++) {
        const degrees = ring ? (turn + spoke * 360 / spokes) % 360 : 0, azimuth = degrees * Math.PI / 180;
        const at = [data.axis[0] + radius * half * Math.cos(azimuth), data.axis[1] + radius * half * Math.sin(azimuth)];
        if (at[0] < 0 || at[1] < 0 || at[0] > wide || at[1] > high) continue;
        list.push({ at, tiles: [polarTile(state, ring, azimuth)], key: ring * spokes + spoke,
          words: ring ? `field radius ${radius.toFixed(2)} half widths, azimuth ${degrees}°: x ${at[0].toFixed(0)}, y ${at[1].toFixed(0)} px`
            : "on the axis" });
      }
    });
    return list;
  }

  let shown = [];
  function drawPsfs() {
    const number = controls.distance.at * data.stops.length + controls.stop.at;
    const state = data.states[number], extent = state.extent_px;
    const reference = controls.same.on ? Math.max(...data.states.map(s => s.extent_px)) : extent;
    clear(pen, field);
    outline();
    shown = places();
    const count = data.polar ? 60 : Math.max(shown.length, 1), beside = data.sources.length;
    const cell = Math.min(field.width / 9, Math.sqrt(wide * high * frameScale ** 2 / count) * 0.92);
    const size = cell / Math.max(1, beside * 0.8) * extent / reference;
    picked = Math.min(picked, shown.length - 1);
    shown.forEach((place, index) => {
      const [x, y] = onCanvas(...place.at);
      place.spot = [x, y];
      place.tiles.forEach((tile, source) => drawTile(pen, tile, x + (source - (beside - 1) / 2) * cell / beside, y, size));
      if (index === picked) {
        pen.strokeStyle = "#f0b429";
        pen.lineWidth = 2;
        pen.strokeRect(x - cell / 2, y - cell / 2, cell, cell);
      }
    });
    scaleBar(pen, field, size / extent, 18);
    clear(close, chosen);
    const place = shown[picked];
    const side = chosen.width / beside, inset = side * 0.96 * extent / reference;
    place.tiles.forEach((tile, source) => {
      drawTile(close, tile, (source + 0.5) * side, chosen.height / 2, inset);
      close.font = "22px system-ui, sans-serif";
      close.fillStyle = "#c8d0d8";
      close.fillText(data.sources[source], source * side + 16, 34);
    });
    scaleBar(close, chosen, inset / extent, 24);
    const settings = [controls.distance.name, data.stops.length > 1 ? controls.stop.name : ""].filter(text => text);
    where.textContent = `${place.words}; ${settings.join(", ")}. ${extent.toFixed(1)} px of the frame across a tile.`;
    field.setAttribute("aria-label", `PSFs over the field at ${settings.join(", ")}; ${place.words}`);
  }

  function pick(index) {
    picked = (index + shown.length) % shown.length;
    draw();
  }

  field.addEventListener("click", event => {
    const box = field.getBoundingClientRect(), scale = field.width / box.width;
    const at = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    const far = place => Math.hypot(place.spot[0] - at[0], place.spot[1] - at[1]);
    if (shown.length) pick(shown.reduce((best, place, index) => far(place) < far(shown[best]) ? index : best, 0));
  });
  field.addEventListener("keydown", event => {
    const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };
    if (!(event.key in steps) || !shown.length) return;
    event.preventDefault();
    pick(picked + steps[event.key]);
  });

  // ---- The zones of a report ----

  const heat = share => {
    const stops = [[20, 24, 48], [70, 50, 130], [170, 60, 120], [235, 110, 70], [250, 220, 120]];
    const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1), low = Math.min(Math.floor(at), stops.length - 2);
    const mix = stops[low].map((v, k) => Math.round(v + (stops[low + 1][k] - v) * (at - low)));
    return `rgb(${mix.join(" ")})`;
  };

  function drawZones() {
    clear(pen, field);
    const centre = [field.width / 2, field.height / 2], reach = Math.min(...centre) - margin;
    const zones = data.zones.filter(zone => zone.state === controls.state.at && zone.channel === controls.channel.at
      && zone.distance === controls.distance.at);
    const rad = degrees => degrees * Math.PI / 180;
    for (const zone of zones) {
      const whole = zone.angle_deg[1] - zone.angle_deg[0] >= 360;
      pen.beginPath();
      pen.arc(...centre, reach * zone.radius[1], rad(zone.angle_deg[0]), rad(zone.angle_deg[1]));
      if (whole) pen.moveTo(centre[0] + reach * zone.radius[0], centre[1]);
      pen.arc(...centre, reach * zone.radius[0], rad(zone.angle_deg[1]), rad(zone.angle_deg[0]), true);
      pen.closePath();
      pen.fillStyle = heat(Math.sqrt(Math.max(zone.excess, 0) / data.largest));
      pen.fill("evenodd");
      pen.strokeStyle = "#05070a";
      pen.lineWidth = 2;
      pen.stroke();
      const middle = zone.radius[0] === 0 && whole ? 0 : reach * (zone.radius[0] + zone.radius[1]) / 2;
      const angle = rad((zone.angle_deg[0] + zone.angle_deg[1]) / 2);
      pen.font = "20px system-ui, sans-serif";
      pen.textAlign = "center";
      pen.lineWidth = 4;
      const spot = [centre[0] + middle * Math.cos(angle), centre[1] + middle * Math.sin(angle) + 7];
      pen.strokeText(zone.text, ...spot);
      pen.fillStyle = "#fff";
      pen.fillText(zone.text, ...spot);
      pen.textAlign = "start";
    }
    pen.strokeStyle = "#5a6672";
    pen.lineWidth = 1;
    pen.beginPath();
    pen.arc(...centre, reach, 0, 2 * Math.PI);
    pen.stroke();
    const words = !data.zones.length ? "All channels and distances" : `${controls.state.name}, channel ${controls.channel.name}, ${controls.distance.name}`;
    where.textContent = zones.length ? `${words}: ${zones.length} zones of the field.`
      : `${words}: no zone where the gap stands out from the noise.`;
    field.setAttribute("aria-label", where.textContent);
  }

  let draw = () => {};
  if (data.kind === "report") {
    chosen.hidden = true;
    field.height = 860;
    slider("state", "Gap", data.state_names, 0);
    slider("channel", "Channel", data.channels, 0);
    slider("distance", "Object distance", data.distances, 0);
    const ramp = [0, 0.25, 0.5, 0.75, 1].map(heat).join(",");
    document.getElementById("legend").innerHTML = `Gap, a share of the light's energy: 0
      <span class="ramp" style="background:linear-gradient(90deg,${ramp})"></span>${data.largest_text} (root scale)`;
    draw = drawZones;
    draw();
    document.documentElement.dataset.ready = "yes";
  } else {
    slider("distance", "Object distance", data.distances, data.start_distance);
    slider("stop", "Stop", data.stops, 0);
    if (data.polar) {
      const steps = Math.round(360 / data.polar.step_deg);
      slider("turn", "Turn the field", Array.from({ length: steps }, (_, k) => `${k * data.polar.step_deg}°`), 0);
    }
    check("same", "One scale for all distances and stops", false);
    document.getElementById("legend").innerHTML = `Tone: square root of light over the peak of each PSF, from 0
      <span class="ramp" style="background:linear-gradient(90deg,#000,#fff)"></span>to 1.`;
    atlas.onload = () => { draw = drawPsfs; draw(); document.documentElement.dataset.ready = "yes"; };
    atlas.src = data.atlas.png;
  }
})();
