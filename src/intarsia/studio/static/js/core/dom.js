/** Elements made in one line. Everything that can be seen is made by `el`, never from a string of HTML. */

/** @typedef {Node | string | number | null | undefined | false} Child */

/** Make an element. A property that begins with `on` is a handler; `class`, `for` and names with a dash are attributes; the
 * others are set as properties; those that are null are left out.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag @param {Record<string, any>} [properties] @param {...(Child | Child[])} children
 * @returns {HTMLElementTagNameMap[T]} */
export function el(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "class" || name === "for" || name === "role" || name === "list" || name.includes("-")) {
      made.setAttribute(name, String(value));
    } else Reflect.set(made, name, value);
  }
  made.append(...nodes(children));
  return made;
}

/** Children without those that are absent.
 * @param {(Child | Child[])[]} children @returns {(Node | string)[]} */
function nodes(children) {
  return children
    .flat()
    .filter((child) => child !== null && child !== undefined && child !== false)
    .map((child) => (child instanceof Node ? child : String(child)));
}

/** Whether something is there; for filters.
 * @template T
 * @param {T | null | undefined} it @returns {it is T} */
export function there(it) {
  return it !== null && it !== undefined;
}

/** Put other children into an element.
 * @param {Element} parent @param {...(Child | Child[])} children */
export function fill(parent, ...children) {
  parent.replaceChildren(...nodes(children));
}

/** Whether keys belong to what is being typed in.
 * @param {Event} event */
export function typing(event) {
  const target = event.composedPath()[0];
  if (target instanceof HTMLInputElement) return !["checkbox", "radio", "range", "button"].includes(target.type);
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement;
}

/** A button.
 * @param {string} label what it says, or with an icon alone its name @param {(event: MouseEvent) => void} act
 * @param {{icon?: SVGElement, class?: string, bare?: boolean} & Record<string, any>} [more] `bare`: the icon alone */
export function button(label, act, more = {}) {
  const { icon, bare, class: classes = "", ...rest } = more;
  return el(
    "button",
    {
      type: "button",
      class: `button ${bare ? "icon" : ""} ${classes}`.trim(),
      "aria-label": bare ? label : null,
      title: bare ? label : null,
      onclick: act,
      ...rest,
    },
    icon,
    bare ? null : icon ? el("span", { class: "label" }, label) : label,
  );
}

/** An element that listens until it leaves the page. */
export class Living extends HTMLElement {
  gone = new AbortController();

  disconnectedCallback() {
    this.gone.abort();
  }
}

/** Call `act` now and at every change, for as long as an element is on the page; it may be put there later.
 * @param {EventTarget} target @param {Element} element @param {() => void} act @param {string} [topic] of the change */
export function follow(target, element, act, topic = "change") {
  let was = false;
  const heard = () => {
    was ||= element.isConnected;
    if (was && !element.isConnected) target.removeEventListener(topic, heard);
    else act();
  };
  target.addEventListener(topic, heard);
  act();
}
