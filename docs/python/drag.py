# %% [markdown]
# # Dragging by script
# The figure's right hand draws a circle while both feet stay; then the same in a window (give `window` on the command line).

# %%
import sys

import numpy as np
import gelenk

figure = gelenk.model("figure")
rest = figure.fk(figure.rest)
place = {name: rest[figure.index(name)][:3, 3] for name in ("hand_r", "foot_l", "foot_r")}
pins = [gelenk.Goal("position", joint=foot, target=place[foot], role="pin") for foot in ("foot_l", "foot_r")]
drag = gelenk.DragSolver(figure)
frames, errors = [], []
for t in np.linspace(0, 2 * np.pi, 120):
    target = place["hand_r"] + 0.15 * np.array([0, np.sin(t), 1 - np.cos(t)])
    result = drag.frame([gelenk.Goal("position", joint="hand_r", target=target), *pins])
    errors.append(result.goal_errors[:, 0])
    frames.append(drag.q)
hand, left, right = np.max(errors, axis=0)
print(f"largest error: hand {1e3 * hand:.2f} mm, feet {1e3 * max(left, right):.3f} mm")
assert hand < 5e-3 and max(left, right) < 2e-3
clip = gelenk.Clip(figure, frames, 60)

# %% [markdown]
# Every thirtieth frame, side by side:

# %%
strip = np.concatenate([gelenk.render(figure, q, size=(240, 320), view="side") for q in frames[::30]], axis=1).view(gelenk.Picture)
strip  # in a notebook the last line of a cell is shown; strip.save("drag.png") writes it

# %%
if "window" in sys.argv:
    with gelenk.show(figure) as view:
        view.play(clip)
        view.wait()  # drag it: view.q and view.goals tell what became of it
        print(view.q)
