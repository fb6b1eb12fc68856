// The theme a person chose, applied before the first paint (hence a classic script in the head):
// "system" follows the browser, "light" and "dark" overrule it. Charts hear of a change through
// the document's "themechange" event, whichever way it came.
(function () {
  const root = document.documentElement;
  const storage = "d3pg.theme";

  /** @returns {string} */
  function read() {
    try {
      return localStorage.getItem(storage) || "system";
    } catch {
      return "system"; // storage is switched off: the theme lasts as long as the page
    }
  }

  /** @param {string} theme */
  function write(theme) {
    try {
      localStorage.setItem(storage, theme);
    } catch {
      // see read
    }
  }

  function announce() {
    document.dispatchEvent(new CustomEvent("themechange"));
  }

  root.dataset.theme = read();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", announce);
  document.addEventListener("DOMContentLoaded", () => {
    const choice = document.getElementById("theme");
    if (!(choice instanceof HTMLSelectElement)) return;
    choice.value = read();
    choice.addEventListener("change", () => {
      root.dataset.theme = choice.value;
      write(choice.value);
      announce();
    });
  });
})();
