// Where the page's data come from: scripts that call colmapExt.put(key, value). Scripts, unlike
// fetch, also load when the page was opened from a file.

const arrived = new Map();
const waiting = new Map();

globalThis.colmapExt = {
  put(key, value) {
    const wait = waiting.get(key);
    if (wait) {
      waiting.delete(key);
      wait(value);
    } else {
      arrived.set(key, value);
    }
  },
};

/** The value of `key`, once a script has put it. Taken once: big texts are not kept. */
export function take(key) {
  if (arrived.has(key)) {
    const value = arrived.get(key);
    arrived.delete(key);
    return Promise.resolve(value);
  }
  return new Promise((resolve) => waiting.set(key, resolve));
}

/** Runs the script at `link`, which puts `key`. Rejects when it is not there. */
export function load(key, link) {
  return new Promise((resolve, reject) => {
    const script = document.createElement('script');
    script.src = link;
    script.onerror = () => {
      script.remove();
      reject(new Error(`${link.split('?')[0]} cannot be read`));
    };
    script.onload = () => script.remove();
    take(key).then(resolve);
    document.head.append(script);
  });
}
