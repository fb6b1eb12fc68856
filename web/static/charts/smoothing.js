/**
 * The debiased exponential average: for a weight b in [0, 1) and finite values v,
 *
 *   m_k = b m_{k-1} + (1 - b) v_k,   s_k = m_k / (1 - b^k),   k counting the finite values only.
 *
 * A constant stays itself from the first value on, and the result depends on the values before it
 * alone. Missing values stay missing and leave the average as it was.
 *
 * @param {(number | null)[]} values
 * @param {number} weight b; 0 gives the values back
 * @returns {(number | null)[]}
 */
export function smooth(values, weight) {
  let average = 0;
  let total = 0; // the weights so far add up to 1 - b^k
  return values.map((value) => {
    if (value === null || value === undefined) return value;
    average = weight * average + (1 - weight) * value;
    total = weight * total + (1 - weight);
    return average / total;
  });
}
