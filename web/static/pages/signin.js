/**
 * Signs in by a shared link. Its token stands behind the #, which a browser sends to nobody and no
 * server logs; here it goes into the form, and out of the address.
 */
import { at } from "../parts/element.js";

const [, token] = location.hash.match(/^#share=([\w-]+)$/) ?? [];
if (token !== undefined) {
  history.replaceState(null, "", location.pathname + location.search);
  at("token", HTMLInputElement).value = token;
  at("signin", HTMLFormElement).requestSubmit();
}
