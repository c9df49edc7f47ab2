# %% [markdown]
# # The lecture in Python
# Every printed number of the chapter on articulated models, again.

# %%
import numpy as np
import gelenk

# %% [markdown]
# ## Forward kinematics in the plane (10.1)

# %%
chain = gelenk.PlanarChain.lecture()
phi = np.radians([30, 45, -20])
print("P_1 ... X:", chain.points(phi).round(2).tolist())
print("D_f:", chain.jacobian(phi).round(2).tolist())

# %% [markdown]
# ## Two links, closed form (10.1.3)

# %%
both = gelenk.two_link(150, 200, target=(250, 550), base=(50, 400))
print(both["case"], np.degrees(both["phi"]).round(2).tolist())

# %% [markdown]
# ## Newton's method with the pseudo-inverse (10.1.4)

# %%
X = np.array([300.0, 500.0])
for i in range(20):
    g = X - chain.end_effector(phi)
    print(i, np.linalg.norm(g))
    if np.linalg.norm(g) < 1e-10:
        break
    phi = phi + np.linalg.pinv(chain.jacobian(phi)) @ g
assert np.linalg.norm(X - chain.end_effector(phi)) < 1e-9

# %% [markdown]
# ## Rotations and Denavit-Hartenberg (10.2)

# %%
R = gelenk.rotation_from_euler("xyz", np.radians([90, 0, 45]))
print("rotation vector:", gelenk.log(R).round(4))
puma = gelenk.DhTable.robot("puma560")
print(puma, puma.parameter_count, "parameters; tool at", puma.frames(np.zeros(6))[-1][:3, 3].round(4))

# %% [markdown]
# ## Every number of the chapter

# %%
for check in gelenk.lecture():
    print(f"{'ok ' if check['ok'] else 'BAD'} {check['id']:<28} {np.round(check['computed'], 4).tolist()}")
    assert check["ok"]
