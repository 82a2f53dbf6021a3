/** The point that was clicked, in numbers. */

import { placed, plain } from "../numbers";
import * as state from "../state";
import { picked } from "../tools";

export function Picked() {
  const [points, at] = [state.cloud.value, picked.value];
  if (!points || at === null) return null;
  const place = placed([...points.xyz.subarray(3 * at, 3 * at + 3)], points.frame.size);
  const labels = state.preview.value?.labels;
  const residual = state.residuals.value?.[at];
  const inlying = state.inliers.value?.[at];
  return (
    <p class="picked" role="status">
      Point {at + 1}: {place}
      {state.unit.value && ` ${state.unit.value}`}
      {labels && <>, segment {labels.names[labels.of[at]]}</>}
      {residual !== undefined && residual === residual && <>, residual {plain(residual, 4)}</>}
      {inlying === 0 && <>, left out</>}
    </p>
  );
}
