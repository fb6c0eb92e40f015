// The crawler on its ground, drawn from samples of a motion: the only place where pixels of it are made.
"use strict"

const INK = { stick: "#0072b2", slip: "#d55e00", flip: "#cc79a7", payload: "#33383d", ground: "#8d8779", soft: "#5d646b" }
const REST_LENGTH = 4 // z_c: the crawler of Ecoflex is 12.5 cm long, and z_c is 1/32 m
const FOOT = 0.85, PAYLOAD = 1.1, HEIGHT = 0.95 // z_c
const FOLDS = 9
const FONT = "Inter, system-ui, -apple-system, 'Segoe UI', 'Liberation Sans', sans-serif"

class Stage {
  constructor(canvas) {
    this.canvas = canvas
    this.context = canvas.getContext("2d")
    this.camera = null
    this.trace = null
  }

  // Columns of the trace in the units shown, what these are, and the setup: see `trace_of` in Python.
  show(trace, units, setup) {
    this.trace = trace
    this.units = units
    this.setup = setup
    this.still = false
    this.stops = stops_of(trace).map((stop) => ({ x: stop.value / units.length, from: stop.from }))
  }

  get begin() { return this.trace.time[0] }
  get end() { return this.trace.time[this.trace.time.length - 1] }

  // What the crawler is at an instant.
  at(time) {
    const { trace, units } = this
    const i = Math.max(1, Math.min(trace.time.length - 1, first_after(trace.time, time)))
    if (trace.time.length < 2) return null
    const share = Math.max(0, Math.min(1, (time - trace.time[i - 1]) / (trace.time[i] - trace.time[i - 1])))
    const between = (name) => trace[name][i - 1] + share * (trace[name][i] - trace[name][i - 1])
    return {
      i, time,
      foot: between("foot"), deformation: between("deformation"), velocity: between("velocity"),
      x: between("foot") / units.length, z: between("deformation") / units.length,
      pressure: between("pressure") / units.pressure,
      heading: trace.sliding[i] > 0 ? Math.sign(trace.foot[i] - trace.foot[i - 1]) : 0,
      open: trace.valve[i] > 0, flipped: trace.flipped[i] > 0,
    }
  }

  // Draw an instant; `lapse` is the time in seconds since the last one.
  draw(time, lapse) {
    const { canvas, context } = this
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio)
      canvas.height = Math.round(height * ratio)
    }
    const now = this.trace && this.at(time)
    if (!now || width === 0) return now
    context.setTransform(ratio, 0, 0, ratio, 0, 0)
    context.clearRect(0, 0, width, height)
    const strip = height < 220 ? 26 : 36
    const scale = Math.max(36, Math.min(78, width / 12.5))
    const ground = height - strip - (height < 220 ? 34 : 50)

    const wanted = now.x + 0.5 * (REST_LENGTH + PAYLOAD - FOOT) + 0.3
    const far = this.camera === null || Math.abs(wanted - this.camera) > 6
    this.camera = far ? wanted : this.camera + (wanted - this.camera) * (1 - Math.exp(-lapse / 0.5))
    this.still = Math.abs(wanted - this.camera) * scale < 0.5
    context.save()
    context.beginPath()
    context.rect(0, 0, width, height - strip)
    context.clip()
    context.translate(width / 2, ground)
    // M g sin(angle) is the slope in units of P_max A_0, which is 0.815 M g for the crawler of Ecoflex.
    this.rise = Math.max(-0.9, Math.min(0.9, 0.815 * this.setup.slope))
    this.room = height - strip - ground
    context.rotate(-Math.asin(this.rise))
    const place = (x) => (x - this.camera) * scale
    const reach = 0.75 * Math.hypot(width, height)
    this.#ground(place, scale, reach, now)
    this.#trail(place, scale, now)
    this.#body(place, scale, now)
    context.restore()
    this.#signs(now)
    this.#strip(width, height, strip, now)
    return now
  }

  #ground(place, scale, reach, now) {
    const { context, units } = this
    const below = context.createLinearGradient(0, 0, 0, 90)
    below.addColorStop(0, "#e4dfd4")
    below.addColorStop(1, "rgba(228, 223, 212, 0)")
    context.fillStyle = below
    context.fillRect(-reach, 0, 2 * reach, 90)
    context.strokeStyle = INK.ground
    context.lineWidth = 2
    line(context, -reach, 0, reach, 0)
    // A tick each natural unit, or each 50 mm.
    const step = units.length_unit === "mm" ? 50 / units.length : 1
    const every = step * scale < 44 ? 2 : 1
    context.fillStyle = INK.soft
    context.font = `11px ${FONT}`
    context.textAlign = "center"
    context.textBaseline = "top"
    context.lineWidth = 1
    const first = Math.ceil((this.camera - reach / scale) / step), last = Math.floor((this.camera + reach / scale) / step)
    for (let k = first; k <= last; k++) {
      const x = place(k * step), named = k % every === 0
      line(context, x, 0, x, named ? 9 : 5)
      if (named && this.#seen(x, 23)) context.fillText((units.length_unit === "mm" ? `${k * 50}` : `${k}`).replace("-", "−"), x, 11)
    }
    const start = place(0)
    if (Math.abs(start) < reach && this.#seen(start, 36)) {
      context.fillStyle = INK.soft
      context.textBaseline = "top"
      context.fillText("start", start, 23)
    }
  }

  // Whether what is so far along the ground and below it is above the strip.
  #seen(along, below) {
    return below - along * this.rise < this.room
  }

  // Where the foot has held, and the way that it slid last.
  #trail(place, scale, now) {
    const { context } = this
    if (this.setup.anchored) return
    for (const stop of this.stops) {
      if (stop.from > now.time) continue
      const x = place(stop.x)
      context.fillStyle = INK.stick
      context.globalAlpha = 0.55
      if (this.setup.ratchet) for (let k = 0; k < 3; k++) tooth(context, x - FOOT * scale * (0.83 - 0.33 * k), 1, 0.1 * scale)
      else context.fillRect(x - FOOT * scale, 1, FOOT * scale, 3)
      context.globalAlpha = 1
    }
    const last = this.stops.filter((stop) => stop.from <= now.time)
    const begun = last.length ? last[last.length - 1] : null
    const from = now.heading ? begun : last.length > 1 ? last[last.length - 2] : null
    if (from === null) return
    const fade = now.heading ? 1 : Math.max(0, 1 - (now.time - begun.from) / (0.9 * this.units.time))
    const gone = place(now.x) - place(from.x), back = FOOT * scale
    if (fade <= 0 || Math.abs(gone) < 1) return
    // What the foot has left behind it: from where its end was to where that end is.
    const begin = place(from.x) - (gone > 0 ? back : 0), end = begin + gone
    const trail = context.createLinearGradient(begin, 0, end, 0)
    trail.addColorStop(0, "rgba(213, 94, 0, 0.08)")
    trail.addColorStop(1, `rgba(213, 94, 0, ${0.85 * fade})`)
    context.fillStyle = trail
    context.fillRect(Math.min(begin, end), -2, Math.abs(gone), 4)
    if (now.heading > 0) {
      // Streaks in the air behind it.
      const right = place(now.x)
      context.strokeStyle = "rgba(213, 94, 0, 0.55)"
      context.lineWidth = 2
      for (const [height, length] of [[0.22, 0.5], [0.5, 0.75], [0.78, 0.4]]) {
        const end = right - (FOOT + 0.12) * scale, long = Math.min(length * scale, gone)
        line(context, end - long, -height * HEIGHT * scale, end, -height * HEIGHT * scale)
      }
    }
  }

  #body(place, scale, now) {
    const { context } = this
    const foot = place(now.x), front = place(now.x + REST_LENGTH + now.z)
    const middle = -(0.1 + 0.5 * HEIGHT) * scale
    // Bellows: fuller the higher the pressure, and bluer.
    const half = (0.27 + 0.12 * now.pressure) * scale, fold = 0.06 * scale, width = (front - foot) / FOLDS
    context.beginPath()
    context.moveTo(foot, middle - half + fold)
    for (let k = 0; k < FOLDS; k++) {
      const x = foot + k * width
      context.quadraticCurveTo(x + width / 2, middle - half - 2 * fold, x + width, middle - half + fold)
    }
    context.lineTo(front, middle + half - fold)
    for (let k = FOLDS; k > 0; k--) {
      const x = foot + k * width
      context.quadraticCurveTo(x - width / 2, middle + half + 2 * fold, x - width, middle + half - fold)
    }
    context.closePath()
    context.fillStyle = mixed([245, 247, 248], [86, 180, 233], now.pressure)
    context.fill()
    context.strokeStyle = "#3f6a83"
    context.lineWidth = 1.5
    context.stroke()
    context.lineWidth = 0.8
    context.globalAlpha = 0.5
    for (let k = 1; k < FOLDS; k++) line(context, foot + k * width, middle - half + fold, foot + k * width, middle + half - fold)
    context.globalAlpha = 1

    // Payload on rollers.
    const radius = 0.1 * scale
    context.fillStyle = INK.payload
    box(context, front, -radius * 1.6 - HEIGHT * scale * 0.95, PAYLOAD * scale, HEIGHT * scale * 0.95, 0.14 * scale)
    context.fill()
    for (const share of [0.24, 0.76]) {
      const x = front + share * PAYLOAD * scale, turned = (x - place(0)) / radius
      context.beginPath()
      context.arc(x, -radius, radius, 0, 2 * Math.PI)
      context.fillStyle = "#fff"
      context.fill()
      context.strokeStyle = INK.payload
      context.lineWidth = 2
      context.stroke()
      line(context, x, -radius, x + radius * Math.cos(turned), -radius + radius * Math.sin(turned))
    }
    context.fillStyle = "#fff"
    context.font = `600 ${Math.round(0.24 * scale)}px ${FONT}`
    context.textAlign = "center"
    context.textBaseline = "middle"
    context.fillText(`p ${now.pressure.toFixed(2)}`, front + 0.5 * PAYLOAD * scale, -radius * 1.6 - 0.48 * HEIGHT * scale)

    this.#foot(foot, scale, now)
  }

  // The foot: clamped, or, where it sticks, on the ground, with teeth in it if it has a ratchet; where it slides, lifted and leaning.
  #foot(foot, scale, now) {
    const { context } = this, back = foot - FOOT * scale
    if (this.setup.anchored) {
      this.#clamp(back, foot, scale)
      return
    }
    const colour = now.heading ? INK.slip : INK.stick
    const depth = 0.1 * scale, lift = now.heading ? depth + 2 : 0
    context.fillStyle = colour
    if (this.setup.ratchet)
      for (let k = 0; k < 3; k++) tooth(context, back + FOOT * scale * (0.17 + 0.33 * k), 1 - lift, now.heading ? depth * 0.6 : depth)
    context.beginPath()
    const top = -(0.05 + HEIGHT) * scale - lift, lean = 0.09 * scale * now.heading
    context.moveTo(back + 0.1 * scale - lean, top)
    context.lineTo(foot - lean, top)
    context.lineTo(foot, 1 - lift)
    context.lineTo(back, 1 - lift)
    context.lineTo(back - lean, top + 0.1 * scale)
    context.closePath()
    context.fill()
    this.#word(now.heading > 0 ? "slides" : now.heading < 0 ? "slides back" : "sticks", 0.5 * (back + foot), top)
  }

  // A wall that the body is bolted to.
  #clamp(back, foot, scale) {
    const { context } = this, top = -(0.05 + HEIGHT) * scale, thick = 0.16 * scale
    context.strokeStyle = INK.soft
    context.lineWidth = 2
    for (let k = 0; k < 6; k++) {
      const y = top + (k + 1) * -top / 6
      line(context, foot - thick, y - 0.16 * scale, foot - thick - 0.16 * scale, y)
    }
    context.fillStyle = INK.payload
    context.fillRect(foot - thick, top, thick, -top)
    for (const share of [0.3, 0.7]) {
      box(context, foot - 0.04 * scale, top * share - 0.05 * scale, 0.2 * scale, 0.1 * scale, 2)
      context.fill()
    }
    this.#word("clamped", foot - 0.5 * thick, top)
  }

  // What the foot does, in a word above it, in the colour that is set.
  #word(word, centre, top) {
    const { context } = this
    context.font = `600 12px ${FONT}`
    const long = context.measureText(word).width + 16
    box(context, centre - long / 2, top - 30, long, 21, 10)
    context.fill()
    context.fillStyle = "#fff"
    context.textAlign = "center"
    context.textBaseline = "middle"
    context.fillText(word, centre, top - 19)
  }

  // The valve, whose sign stays where it is.
  #signs(now) {
    const { context } = this
    context.textBaseline = "middle"
    context.textAlign = "left"
    context.font = `600 13px ${FONT}`
    context.beginPath()
    context.arc(22, 22, 7, 0, 2 * Math.PI)
    context.fillStyle = now.open ? INK.payload : "#fff"
    context.fill()
    context.strokeStyle = INK.payload
    context.lineWidth = 2
    context.stroke()
    context.fillStyle = INK.payload
    const text = now.open ? "valve open" : "valve shut"
    context.fillText(text, 36, 22)
    if (now.flipped) {
      const left = 46 + context.measureText("valve open").width
      context.font = `600 12px ${FONT}`
      context.fillStyle = INK.flip
      box(context, left, 11, context.measureText("flipped").width + 18, 21, 10)
      context.fill()
      context.fillStyle = "#23282d"
      context.fillText("flipped", left + 9, 22)
    }
  }

  // The valve along time: open holds are dark, flipped ones are marked, and where we are.
  #strip(width, height, strip, now) {
    const { context, trace } = this
    const left = 14, right = width - 14, top = height - strip + 4, tall = strip - 14
    const place = (time) => left + ((time - this.begin) / (this.end - this.begin)) * (right - left)
    let from = 1
    for (let i = 2; i <= trace.time.length; i++) {
      if (i < trace.time.length && trace.valve[i] === trace.valve[from] && trace.flipped[i] === trace.flipped[from]) continue
      const x = place(trace.time[from - 1]), wide = place(trace.time[i - 1]) - x
      context.fillStyle = trace.flipped[from] > 0 ? INK.flip : "#a9a498"
      if (trace.valve[from] > 0) context.fillRect(x, top, wide, tall)
      else context.fillRect(x, top + tall - 2, wide, 2)
      if (trace.flipped[from] > 0) context.fillRect(x, top + tall + 2, wide, 3)
      from = i
    }
    const x = place(now.time)
    context.fillStyle = "#23282d"
    context.fillRect(x - 1, top - 3, 2, tall + 9)
    context.beginPath()
    context.arc(x, top - 3, 4, 0, 2 * Math.PI)
    context.fill()
  }

  // The time that a place on the strip stands for, or null off it.
  time_at(x, y) {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight
    if (!this.trace || y < height - 46) return null
    return this.begin + Math.max(0, Math.min(1, (x - 14) / (width - 28))) * (this.end - this.begin)
  }
}

// Places where the foot held, and since when.
function stops_of(trace) {
  const stops = []
  let held = null
  for (let i = 0; i < trace.time.length; i++) {
    const x = trace.foot[i]
    if (trace.sliding[i] > 0) held = null
    else if (held === null || Math.abs(x - held) > 1e-9) {
      held = x
      stops.push({ value: x, from: trace.time[i] })
    }
  }
  return stops
}

function first_after(times, time) {
  let low = 0, high = times.length
  while (low < high) {
    const middle = (low + high) >> 1
    if (times[middle] < time) low = middle + 1
    else high = middle
  }
  return low
}

function line(context, x1, y1, x2, y2) {
  context.beginPath()
  context.moveTo(x1, y1)
  context.lineTo(x2, y2)
  context.stroke()
}

function tooth(context, x, y, depth) {
  context.beginPath()
  context.moveTo(x - depth * 0.8, y)
  context.lineTo(x + depth * 0.5, y)
  context.lineTo(x - depth * 0.5, y + depth)
  context.closePath()
  context.fill()
}

function box(context, x, y, width, height, radius) {
  context.beginPath()
  context.roundRect(x, y, width, height, radius)
}

function mixed(from, to, share) {
  const at = Math.max(0, Math.min(1, share))
  return `rgb(${from.map((value, k) => Math.round(value + at * (to[k] - value))).join(",")})`
}
