// Elements of the page with their types. What has to be there and is not is a mistake of ours: it throws.

/**
 * @template {Element} E
 * @param {ParentNode} root
 * @param {string} selector
 * @param {new () => E} kind
 * @returns {E}
 */
export function need(root, selector, kind) {
  const element = maybe(root, selector, kind);
  if (!element) throw new Error(`The page has no ${selector}.`);
  return element;
}

/**
 * @template {Element} E
 * @param {ParentNode} root
 * @param {string} selector
 * @param {new () => E} kind
 * @returns {E | null}
 */
export function maybe(root, selector, kind) {
  const element = root.querySelector(selector);
  return element instanceof kind ? element : null;
}

/**
 * @template {Element} E
 * @param {ParentNode} root
 * @param {string} selector
 * @param {new () => E} kind
 * @returns {E[]}
 */
export function all(root, selector, kind) {
  return [...root.querySelectorAll(selector)].flatMap((element) => (element instanceof kind ? [element] : []));
}

/**
 * What the server has written into the page as JSON; the caller says its type.
 * @param {string} id
 */
export function dataOf(id) {
  return JSON.parse(need(document, `script#${id}`, HTMLScriptElement).textContent);
}

/**
 * The closest element around the target of an event that matches, null if there is none.
 * @template {Element} E
 * @param {EventTarget | null} target
 * @param {string} selector
 * @param {new () => E} kind
 * @returns {E | null}
 */
export function around(target, selector, kind) {
  const element = target instanceof Element ? target.closest(selector) : null;
  return element instanceof kind ? element : null;
}

/**
 * Whether the target of an event is a control of this name, or one of these names.
 * @param {EventTarget | null} target
 * @param {...string} names
 */
export function isNamed(target, ...names) {
  const known = target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
  return known && names.includes(target.name);
}
