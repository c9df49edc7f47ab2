# %% [markdown]
# # Rig a body and play it
# A body without a skeleton (here the figure's own skin) gets one, and moves.

# %%
import numpy as np
import gelenk

figure = gelenk.model("figure")
body, report = gelenk.rig(figure.skin.vertices, figure.skin.triangles, name="rigged")
print(body, f"confidence {report['confidence']:.2f}, pose {report['pose']}")
assert report["confidence"] > 0.5

# %%
raised = []
for s in np.linspace(0, 1, 30):
    wave = gelenk.solve(body, {"hand_l": body.fk(body.rest)[body.index("hand_l")][:3, 3] + s * np.array([0.1, 0.3, 0.1])},
                        restarts=0)
    raised.append(wave.q)
clip = gelenk.Clip(body, raised, 30)
surface = body.skin(body.fk(clip.q))  # (frames, vertices, 3)
print("the surface moves by up to", np.abs(surface[-1] - surface[0]).max().round(3), "m")
assert np.abs(surface[-1] - surface[0]).max() > 0.2

# %%
before_and_after = np.concatenate([gelenk.render(body, q, size=(320, 400), bones=True) for q in (clip.q[0], clip.q[-1])], axis=1)
before_and_after = before_and_after.view(gelenk.Picture)
before_and_after

# %% [markdown]
# The same motion on the built-in figure, and a file that other programs open:

# %%
carried, told = clip.retarget(figure)
print(carried, told["scale"])
gelenk.save("rigged.glb", body, clip)
again = gelenk.load("rigged.glb")
assert len(again.clip) == len(clip) and again.joint_count >= body.joint_count
