# %% [markdown]
# # Rig a body and play it
# A body without a skeleton (here the figure's own skin) gets one, and moves.

# %%
import numpy as np
import gelenk

figure = gelenk.model("figure")
body, report = gelenk.rig(figure.skin.vertices, figure.skin.triangles, name="rigged")
print(body, f"confidence {report['confidence']:.2f}, pose {report['pose']}")

# %%
raised = []
for s in np.linspace(0, 1, 30):
    wave = gelenk.solve(body, {"hand_l": body.fk(body.rest)[body.index("hand_l")][:3, 3] + s * np.array([0.1, 0.3, 0.1])},
                        restarts=0)
    raised.append(wave.q)
clip = gelenk.Clip(body, raised, 30)
surface = body.skin(body.fk(clip.q))  # (frames, vertices, 3)
print("the surface moves by up to", np.abs(surface[-1] - surface[0]).max().round(3), "m")

# %% [markdown]
# The same motion on the built-in figure, and a file that other programs open:

# %%
carried, told = clip.retarget(figure)
print(carried, told["scale"])
gelenk.save("rigged.glb", body, clip)
print(gelenk.load("rigged.glb"))
