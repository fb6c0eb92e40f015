// The page's wiring: what is touched is asked of Python, what Python tells is shown. No physics here.
"use strict"

window.stickslip = (() => {
  const by_id = (id) => document.getElementById(id)
  const page = by_id("page"), stage = new Stage(by_id("stage"))
  const sliders = new Map([...document.querySelectorAll(".number")].map((each) => [each.dataset.number, each]))
  // What is wanted, and what was told of the motion that is drawn: behind it while a kernel is compiled.
  let sources = null, wanted = null, told = null
  let number = 0, waiting = false, actions = []
  let time = 0, playing = true, pace = 2, bit = 0, last = null, drawn = 0, silence = 0, placed = ""

  // ---- Asking: one question at a time, and of several changes of one thing only the last.

  function ask(action) {
    if (action.do === "set") actions = actions.filter((each) => each.do !== "set" || each.name !== action.name)
    actions.push(action)
    if (action.do === "set") by_id("preset").value = "" // it is none any more
    if (!waiting) send()
  }

  function send() {
    waiting = true
    number += 1
    sources.asked.data = { json: [JSON.stringify({ number, actions })] }
    actions = []
    clearTimeout(silence)
    silence = setTimeout(() => say("No answer yet: the machine has much else to do, or `stickslip explore` has ended."), 8000)
  }

  function say(sentence) {
    by_id("notice").hidden = !sentence
    by_id("notice").textContent = sentence
  }

  const COMPILING = "Compiling what this needs: up to a minute, once. What is drawn is from before."

  const set = (name, value) => ask({ do: "set", name, value })

  // ---- Sliders: a place from 0 to 1000, and the number that stands there.

  function value_of(slide) {
    const low = Number(slide.dataset.low), high = Number(slide.dataset.high), share = slide.value / 1000
    switch (slide.dataset.scale) {
      case "log": return rounded(low * (high / low) ** share, low, high)
      case "square": return rounded(low + (high - low) * share ** 2, low, high)
      case "decades": return Number(`1e${Math.round(Math.log10(low) + share * (Math.log10(high) - Math.log10(low)))}`)
      default: return rounded(low + (high - low) * share, low, high, (high - low) / 1000)
    }
  }

  function place_of(slide, value) {
    const low = Number(slide.dataset.low), high = Number(slide.dataset.high)
    switch (slide.dataset.scale) {
      case "log": case "decades": return 1000 * Math.log(value / low) / Math.log(high / low)
      case "square": return 1000 * Math.sqrt((value - low) / (high - low))
      default: return 1000 * (value - low) / (high - low)
    }
  }

  function rounded(value, low, high, step) {
    const near = step ? Math.round(value / step) * step : value
    return Math.max(low, Math.min(high, Number(near.toPrecision(3))))
  }

  for (const [name, each] of sliders) {
    const slide = each.querySelector(".slide"), exact = each.querySelector(".exact")
    slide.addEventListener("input", () => {
      const value = value_of(slide)
      exact.value = written(value)
      set(name, value)
    })
    exact.addEventListener("change", () => {
      const value = Number(exact.value.replace(",", ".").replace("−", "-"))
      set(name, exact.value.trim() === "" || Number.isNaN(value) ? exact.value : value)
    })
  }

  const written = (value) => (Math.abs(value) < 1e-3 && value !== 0 ? value.toExponential().replace("e", "e") : String(value))

  // ---- Choices.

  function label(element, attribute, value) {
    if (element.getAttribute(attribute) !== value) element.setAttribute(attribute, value)
  }

  function choices(attribute, chosen) {
    for (const each of document.querySelectorAll(`[data-${attribute}]`))
      if (each.getAttribute("role") === "radio") label(each, "aria-checked", String(each.dataset[attribute] === chosen))
  }

  for (const each of document.querySelectorAll("[data-units]")) each.addEventListener("click", () => set("units", each.dataset.units))
  for (const each of document.querySelectorAll("[data-policy]")) each.addEventListener("click", () => set("policy", each.dataset.policy))
  for (const each of document.querySelectorAll("button[data-drive]")) each.addEventListener("click", () => set("drive", each.dataset.drive))
  for (const each of document.querySelectorAll("[data-pace]"))
    each.addEventListener("click", () => { pace = Number(each.dataset.pace); choices("pace", each.dataset.pace) })
  choices("pace", "2")
  by_id("preset").addEventListener("change", (event) => {
    if (event.target.value) ask({ do: "preset", name: event.target.value })
    time = 0
  })

  for (const each of document.querySelectorAll("[data-switch]"))
    each.querySelector("input").addEventListener("change", (event) => set(each.dataset.switch, event.target.checked))

  // ---- The word.

  function change_word(word) {
    if (word) set("word", word)
  }

  by_id("word").addEventListener("change", (event) => set("word", event.target.value.trim()))
  by_id("more").addEventListener("click", () => change_word(wanted.setup.word + "0"))
  by_id("fewer").addEventListener("click", () => change_word(wanted.setup.word.slice(0, -1)))

  function show_word(word) {
    const bits = by_id("bits")
    while (bits.children.length > word.length) bits.lastChild.remove()
    while (bits.children.length < word.length) {
      const place = bits.children.length, button = document.createElement("button")
      button.type = "button"
      button.addEventListener("click", () => {
        const now = wanted.setup.word
        change_word(now.slice(0, place) + (now[place] === "1" ? "0" : "1") + now.slice(place + 1))
      })
      bits.append(button)
    }
    ;[...word].forEach((letter, k) => {
      const button = bits.children[k]
      if (button.textContent === letter) return
      button.textContent = letter
      button.setAttribute("aria-pressed", String(letter === "1"))
      button.setAttribute("aria-label", `bit ${k + 1}: ${letter === "1" ? "open" : "shut"}`)
    })
    if (document.activeElement !== by_id("word")) by_id("word").value = word
  }

  // ---- You.

  function press(open) {
    bit = open ? 1 : 0
    by_id("hold-open").classList.toggle("open", open)
  }

  // Where the space bar has another use: in what is typed into, and on a button that was reached by keys.
  const typing = (target) => target instanceof HTMLElement && target.matches("input[type=text], select, button:not(#hold-open)")
  document.addEventListener("click", (event) => {
    if (event.detail > 0 && document.activeElement instanceof HTMLButtonElement) document.activeElement.blur()
  })
  document.addEventListener("keydown", (event) => {
    if (event.code !== "Space" || typing(event.target) || by_id("program-dialog").open || !wanted) return
    event.preventDefault()
    if (event.repeat) return
    press(true)
    if (wanted.setup.drive !== "live") set("drive", "live")
  })
  document.addEventListener("keyup", (event) => {
    if (event.code !== "Space") return
    if (!typing(event.target)) event.preventDefault()
    press(false)
  })
  window.addEventListener("blur", () => press(false))
  by_id("hold-open").addEventListener("pointerdown", (event) => { event.preventDefault(); press(true) })
  for (const kind of ["pointerup", "pointercancel"]) window.addEventListener(kind, () => press(false))
  by_id("hold-open").addEventListener("contextmenu", (event) => event.preventDefault())
  by_id("keep").addEventListener("click", () => ask({ do: "keep" }))

  // ---- Telling.

  // Only what has changed is written: the browser finds the style of all again that is touched, and Bokeh waits for it.
  const written_last = new Map()
  function put(id, html) {
    if (written_last.get(id) === html) return
    written_last.set(id, html)
    by_id(id).innerHTML = html
  }

  const escaped = (text) => text.replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`)

  const EXPONENTS = [...document.querySelectorAll(".exponents")]
  const SLOW = [...document.querySelectorAll(".slow")].filter((each) => !EXPONENTS.includes(each))
  function stale(some, on) {
    for (const each of some) if (each.classList.contains("stale") !== on) each.classList.toggle("stale", on)
  }

  const lowered = (text) => text.replace(/_([a-z]+)/g, "<sub>$1</sub>")
  const unit = (text) => `<span class="unit">${lowered(text)}</span>`
  const digits = (value) => (Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) >= 10 ? value.toFixed(1) : Math.abs(value) >= 0.1 || value === 0 ? value.toFixed(2) : value.toPrecision(2))

  function on_told() {
    const news = JSON.parse(sources.told.data.json[0])
    waiting = news.number < number
    if (!waiting) clearTimeout(silence)
    say(news.notice || (news.compiling ? COMPILING : ""))
    wanted = news
    show_controls(news)
    if (news.moved) show(news)
    if (news.compiling) stale([...SLOW, ...EXPONENTS], true)
    page.classList.toggle("compiling", Boolean(news.compiling))
    keep_link(news.query)
    page.dataset.answered = news.number
    page.removeAttribute("aria-busy")
    if (actions.length && !waiting) send()
  }

  function show_controls(news) {
    const setup = news.setup
    for (const [name, each] of sliders) {
      const slide = each.querySelector(".slide"), exact = each.querySelector(".exact")
      each.classList.toggle("idle", news.without_effect.includes(name))
      if (actions.some((action) => action.name === name)) continue
      if (Number(value_of(slide)) !== setup[name]) slide.value = place_of(slide, setup[name])
      if (document.activeElement !== exact || news.notice) exact.value = written(setup[name])
      put(`${name}-si`, setup.units === "SI" ? lowered(news.si[name] || "") : "")
    }
    for (const each of document.querySelectorAll("[data-switch]")) {
      each.classList.toggle("idle", news.without_effect.includes(each.dataset.switch))
      each.querySelector("input").checked = setup[each.dataset.switch]
    }
    choices("units", setup.units)
    choices("drive", setup.drive)
    choices("policy", setup.policy)
    for (const each of document.querySelectorAll(".drive")) each.hidden = each.dataset.for !== setup.drive
    const policy = document.querySelector(`[data-policy="${setup.policy}"]`)
    by_id("weighed").hidden = policy.dataset.weighed !== "true"
    by_id("flips").hidden = setup.drive === "live"
    show_word(setup.word)
    by_id("program").textContent = news.program
  }

  function show(news) {
    const anew = !told || told.moved.units !== news.moved.units || told.moved.drive !== news.moved.drive
    if (told && told.moved.units !== news.moved.units) time *= news.units.time / told.units.time
    else if (anew) time = 0
    told = news
    const { moved, units } = news
    const columns = {}
    for (const [name, column] of Object.entries(sources.trace.data)) columns[name] = column
    stage.show(columns, units, moved)
    put("distance", digits(news.distance) + unit(units.length_unit))
    put("distance-more", moved.anchored ? "the foot is clamped" : `in ${digits(news.time)} ${lowered(units.time_unit)}, ${news.slips} slip${news.slips === 1 ? "" : "s"}`)
    put("model", escaped(`Integrated: ${news.model}.`))
    if (anew) for (const each of document.querySelectorAll("[data-unit]")) each.innerHTML = lowered(units[`${each.dataset.unit}_unit`])
    // t_c is 1/16 s of the crawler in SI.
    put("usual-pace", moved.units === "SI" ? `real time / ${(0.5 / units.time).toFixed(0)}` : "2 t<sub>c</sub> a second")
    const live = moved.drive === "live"
    stale(SLOW, !live)
    stale(EXPONENTS, !live)
    if (live) {
      for (const name of ["speed", "memory", "exponent"]) {
        put(name, "–")
        put(`${name}-more`, "of a word or a policy")
      }
      nothing("no-memory", "Memory is measured on flips, which no hand makes.")
      nothing("no-plane", "")
    }
  }

  function on_measured() {
    const news = JSON.parse(sources.measured.data.json[0])
    if (!told || news.number !== told.number) return
    if (news.failure) {
      stale(SLOW, false)
      stale(EXPONENTS, false)
      say(news.failure)
    }
    if (news.run) show_run(news.run)
    if (news.exponents) show_exponents(news.exponents)
  }

  function show_run(run) {
    stale(SLOW, false)
    const { moved, units } = told
    put("speed", digits(run.speed) + unit(units.speed_unit))
    put("speed-more", escaped(`over ${run.holds} holds`))
    if (run.memory === null) {
      put("memory", "–")
      put("memory-more", escaped(moved.dither === 0 ? "no flips, no message" : "flips are too rare"))
      nothing("no-memory", moved.dither === 0 ? "Without flips there is no message to remember." : run.doubt)
    } else {
      put("memory", digits(run.memory) + unit("holds"))
      put("memory-more", escaped(run.doubt ? "rough: the flips are few" : `of at most ${run.bound}`))
      by_id("memory-more").title = run.doubt
      nothing("no-memory", "")
    }
    nothing("no-plane", "")
    put("front", escaped(`Front of the default body at hold 0.5 and flips ${run.front}; the grey area is what words reach.`))
  }

  function show_exponents(found) {
    stale(EXPONENTS, false)
    put("exponent", found.exponents[0].toFixed(3).replace("-", "−") + unit(`/${told.units.time_unit}`))
    put("exponent-more", escaped(`± ${found.errors[0].toFixed(3)}, ${found.verdict}`))
  }

  function nothing(id, text) {
    by_id(id).hidden = !text
    by_id(id).textContent = text
  }

  // ---- The link, and the program.

  let linking = 0
  function keep_link(query) {
    clearTimeout(linking)
    linking = setTimeout(() => history.replaceState(null, "", query ? `?${query}` : location.pathname), 250)
  }

  async function copied(button, text) {
    const before = button.textContent
    try {
      await navigator.clipboard.writeText(text)
      button.textContent = "Copied"
    } catch {
      button.textContent = "Not allowed"
    }
    setTimeout(() => { button.textContent = before }, 1500)
  }

  by_id("copy-link").addEventListener("click", (event) => {
    const query = wanted.query ? `?${wanted.query}` : ""
    copied(event.target, location.origin + location.pathname + query)
  })
  by_id("show-program").addEventListener("click", () => by_id("program-dialog").showModal())
  by_id("close-program").addEventListener("click", () => by_id("program-dialog").close())
  by_id("copy-program").addEventListener("click", (event) => copied(event.target, wanted.program))

  // ---- The clock.

  const PLAY = '<svg width="12" height="12" viewBox="0 0 12 12"><path d="M2 0l10 6-10 6z" fill="currentColor"/></svg>'
  const PAUSE = '<svg width="12" height="12" viewBox="0 0 12 12"><path d="M1 0h3.6v12H1zM7.4 0H11v12H7.4z" fill="currentColor"/></svg>'
  const AGAIN = '<svg width="13" height="12" viewBox="0 0 13 12"><path d="M0 0h2.4v12H0zM13 0v12L3.6 6z" fill="currentColor"/></svg>'

  function play(on) {
    playing = on
    put("play", on ? PAUSE : PLAY)
    by_id("play").setAttribute("aria-label", on ? "Pause" : "Play")
  }

  put("again", AGAIN)
  by_id("play").addEventListener("click", () => play(!playing))
  by_id("again").addEventListener("click", () => {
    time = 0
    if (wanted.setup.drive === "live") ask({ do: "restart" })
  })
  by_id("stage").addEventListener("pointerdown", (event) => {
    const there = stage.time_at(event.offsetX, event.offsetY)
    if (there === null || told.moved.drive === "live") return
    time = there
    const move = (moved) => { time = stage.time_at(moved.offsetX, event.offsetY) ?? time }
    const stop = () => { by_id("stage").removeEventListener("pointermove", move) }
    by_id("stage").addEventListener("pointermove", move)
    window.addEventListener("pointerup", stop, { once: true })
  })

  function clock(at, units) {
    const few = (value, unit) => `${value.toFixed(unit === "mm" ? 0 : unit === "s" ? 2 : 1)} ${lowered(unit)}`
    const where = told.moved.anchored ? `stretched by ${few(at.deformation, units.length_unit)}` : `foot at ${few(at.foot, units.length_unit)}`
    return `${where} · ${few(at.time, units.time_unit)}`
  }

  // At the space bar a hold is asked for shortly before the one that is played ends.
  const LEAD = 0.09 // seconds

  function frame(now) {
    requestAnimationFrame(frame)
    const lapse = last === null ? 0 : Math.min(0.1, (now - last) / 1000)
    last = now
    if (!told || !stage.trace) return
    if (playing) time += lapse * pace * told.units.time
    if (told.moved.drive === "live") {
      if (playing && !waiting && stage.end - time < LEAD * pace * told.units.time) ask({ do: "bit", value: bit })
      if (stage.end < time - told.units.time) time = stage.end // it began anew
      time = Math.max(stage.begin, Math.min(time, stage.end))
    } else if (time > stage.end || time < stage.begin) time = stage.begin
    const place = `${time} ${window.innerWidth} ${window.devicePixelRatio}`
    if (place === placed && stage.still) return
    placed = place
    const at = stage.draw(time, lapse)
    if (at && (now - drawn > 45 || !playing) && by_id("program-dialog").open === false) {
      drawn = now
      put("clock", clock(at, told.units))
      sources.cursor.data = { time: [at.time], foot: [at.foot], deformation: [at.deformation], velocity: [at.velocity] }
    }
  }

  return {
    start(models) {
      sources = models
      sources.told.properties.data.change.connect(on_told)
      sources.measured.properties.data.change.connect(on_measured)
      play(!window.matchMedia("(prefers-reduced-motion: reduce)").matches)
      on_told()
      if (sources.measured.data.json.length) on_measured()
      requestAnimationFrame(frame)
    },
    // For tests and timings: what is seen, and the sources it comes from.
    get models() { return sources },
    get seen() { return { told, wanted, time, trace: stage.trace && { ...stage.trace }, at: stage.trace && stage.at(time) } },
  }
})()
