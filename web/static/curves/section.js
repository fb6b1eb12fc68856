/** The curves of a page: a panel a task, and the legend beside them. */
import { at, keyed } from "../parts/element.js";
import { identities } from "../parts/identity.js";
import { xLabel } from "../parts/view.js";
import { sharedRange } from "./drawing.js";
import { Legend } from "./legend.js";
import { Panel } from "./panel.js";
import { isNormalized } from "./question.js";
import { hiddenLabels } from "./selection.js";

/**
 * @import { Entry } from "../parts/identity.js"
 * @import { View } from "../parts/view.js"
 * @import { Fields } from "./drawing.js"
 * @import { Shown } from "./panel.js"
 */

export class CurvesSection {
  #view;
  #legend;
  #showPanels;

  /** @param {View<Fields>} view */
  constructor(view) {
    this.#view = view;
    const legend = new Legend(view);
    this.#legend = legend;
    this.#showPanels = keyed(
      at("panels"),
      (/** @type {Shown} */ { panel }) => panel.environment,
      ({ panel }) => new Panel(panel.environment, view, (reading) => legend.read(reading)),
    );
  }

  /**
   * @param {Api.Panel[]} panels
   * @param {Entry[]} entries all that there are, shown or not
   * @param {number | null} xMax where the x axis ends, if that is known
   */
  draw(panels, entries, xMax) {
    const view = this.#view;
    const known = identities(entries);
    const hidden = hiddenLabels(panels, view);
    const metric = view.get("metric");
    const axes = {
      xLabel: xLabel(view.get("x")),
      yLabel: isNormalized(view) ? `normalised ${metric}` : metric,
      xMax,
      yShared: sharedRange(panels, view, hidden),
    };
    this.#legend.update(known, panels, hidden);
    this.#showPanels(panels.map((panel) => ({ panel, known, axes, hidden })));
  }
}
