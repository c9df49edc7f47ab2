#!/usr/bin/env python3
"""Writes tiny files of our own, and those of tests/data, as seeds for the fuzz targets: make_seeds.py FOLDER"""
import base64
import os
import struct
import sys

SEEDS = {
    "obj": [b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", b"v 0 0 0\nv 1 0 0 1\nv 1 1 0 .1 .2 .3\nvt 0 0\nvn 0 0 1\nv 0 1 0\nf 1/1/1 2//1 \\\n3/1 -1\n"],
    "pinocchio_skeleton": [b"0 0 0 0 -1\n1 1 0 0 0\n2 1 1 0 1\n", b"hip 0 1e-3 0 -1\r\nknee 0 -.5 0 hip\r\n"],
    "pinocchio_weights": [b"0.5 0.5\n0 1\n1 0\n", b"1 0\n"],
    "asf": [b":units\nlength 0.45\nangle deg\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\nposition 0 0 0\norientation 0 0 0\n:bonedata\nbegin\nid 1\nname a\n"
            b"direction 0 -1 0\nlength 2\naxis 0 0 20 XYZ\ndof rx ry rz\nlimits (-160.0 20.0)\n(-inf inf)\n(0 1)\nend\nbegin\nname b\ndirection 1 0 0\nlength 0\n"
            b"axis 0 0 0 XYZ\nend\n:hierarchy\nbegin\nroot a\na b\nend\n",
            b":root\naxis ZYX\norder rz tx l\n:bonedata\nbegin name A direction 0 0 1 length 1 axis 1 2 3 YZX dof l tz rx limits (0 1) (-1 1) (-inf inf) bodymass 1 cofmass .5 end\n:hierarchy begin root A end"],
    "amc": [b"#!OML\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 1 2 3 4 5\na 7.6e-016 -1\n2\na 1 2\nroot 0 0 0 0 0 0\n", b":RADIANS\n:SAMPLES-PER-SECOND 60\n1\nroot 0 0 0 0 0 0\nstranger 1 2\na 0 0\n"],
    "bvh": [b"HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\nJOINT b\n{\nOFFSET 1 0 0\nCHANNELS 3 "
            b"Yrotation Zrotation Xrotation\nEnd Site\n{\nOFFSET .5 0 0\n}\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.025\n0 1 0 0 0 0 0 0 0\n0 1 0 90 0 0 90 90 0\n",
            b"\xef\xbb\xbfHIERARCHY\r\nROOT a b\r\n{\r\nOFFSET 0 0 0\r\nCHANNELS 1 Xrotation\r\nEnd Site tip\r\n{\r\nOFFSET 0 1 0\r\n}\r\n}\r\nROOT c\r\n{\r\nOFFSET 1 0 0\r\n"
            b"CHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation\r\nJOINT d\r\n{\r\nOFFSET 0 1 0\r\nCHANNELS 6 Xposition Yposition Zposition Zrotation "
            b"Xrotation Yrotation\r\n}\r\n}\r\nMOTION\r\nFrames:3\r\nFrame Time:0.1\r\n1 0 0 0 0 0 0 0 1 0 0 0 0\r\n2 0 0\r\n"],
    "tutorial": [b"NumJoints: 3\nNonAnimatedJointPositions:\n0.0, 0.0, 0.0,\n0, 1, 0,\n0, 2, 0,\nNumBones: 2\n0, 1,\n1, 2,\nNumJointHierarchies: 1\n"
                 b"NumJoints-all: 3\n0, 1, 2,\n", b"NumJoints: 2\nJointAngles:\n0.1, 0, 0,\n0, -0.17, 0,\n"],
    "urdf": [b'<robot name="r"><link name="a"><visual><geometry><box size="1 2 3"/></geometry></visual></link><link name="b"/>'
             b'<joint name="j" type="revolute"><origin xyz="0 0 1" rpy="0 1 0"/><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint></robot>',
             b'<robot><link name="a"/><link name="b"/><link name="c"/><joint name="i" type="continuous"><parent link="a"/><child link="b"/></joint>'
             b'<joint name="j" type="prismatic"><parent link="a"/><child link="c"/><limit/><mimic joint="i" multiplier="-1" offset="2"/></joint></robot>',
             b'<robot><link name="a"><inertial><mass value="2"/></inertial></link><link name="b"/><link name="c"/><link name="d"/><joint name="i" type="floating"><parent link="a"/><child link="b"/></joint>'
             b'<joint name="j" type="revolute"><parent link="b"/><child link="c"/><limit lower="0" upper="1"/></joint><joint name="k" type="revolute"><parent link="b"/><child link="d"/>'
             b'<limit lower="-2" upper="0"/><mimic joint="j" multiplier="-2"/></joint></robot>'],
    "stl": [b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
            b" " * 80 + struct.pack("<I12fH", 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)],
    "dh": [b"convention modified\nrevolute 0 0 0.1 0\nprismatic 0.5 90 0 0\n"],
    "nurbs": [b"nurbs 1\ndegree 2 1\npoints 3 2\nknots_u 0 0 0 1 1 1\nknots_v 0 0 1 1\n" + b"".join(b"point %d %d 0.5 1\n" % (i // 2, i % 2) for i in range(6))],
    "mapping": [b"# bones : joints\na b : h s t\nc : h 3\n", b"a : h s\r\nb : s t\r\n"],
    "scene": [b'{"format":"gelenk-scene","version":1,"model":{"name":"figure","skeleton":"s"},"q":[1,0,0,0,0.5],"goals":[{"name":"b","kind":"pose","joint":"b","point":[0,0,0],'
              b'"target":[1,2,3],"state":"held","handle":true,"orientation":[1,0,0,0],"surface":{"triangle":0,"barycentric":[1,0,0]}}],"solver":"hybrid",'
              b'"camera":{"target":[0,0,0],"up":[0,1,0],"distance":2,"azimuth":0,"elevation":0,"vertical_field_of_view":0.5,"orthographic":false},'
              b'"show":{"skin":true},"theme":"dark","selected":"b","panels":{"Motion":{"speed":1}}}'],
    "gltf": [],
}

triangle = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + struct.pack("<12H", *[0, 0, 0, 0] * 3) + struct.pack("<12f", *[1, 0, 0, 0] * 3)
triangle += struct.pack("<16f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1) + struct.pack("<2f", 0, 1) + struct.pack("<8f", 0, 0, 0, 1, 0, 0, 1, 0)
views = [(0, 36), (36, 24), (60, 48), (108, 64), (172, 8), (180, 32)]
SEEDS["gltf"].append((
    '{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"name":"a","translation":[0,1,0],"rotation":[0,0,0,1]},{"mesh":0,"skin":0}],'
    '"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],"skins":[{"joints":[0],"inverseBindMatrices":3}],'
    '"animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}}],"samplers":[{"input":4,"output":5}]}],'
    '"buffers":[{"byteLength":%d,"uri":"data:application/octet-stream;base64,%s"}],"bufferViews":[%s],"accessors":['
    '{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":3,"type":"VEC4"},'
    '{"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"},{"bufferView":3,"componentType":5126,"count":1,"type":"MAT4"},'
    '{"bufferView":4,"componentType":5126,"count":2,"type":"SCALAR"},{"bufferView":5,"componentType":5126,"count":2,"type":"VEC4"}]}'
    % (len(triangle), base64.b64encode(triangle).decode(),
       ",".join('{"buffer":0,"byteOffset":%d,"byteLength":%d}' % v for v in views))).encode())



def boxes_to_rig(template, boxes):
    """Bodies of boxes (two corners each, millimetres) as rig_fuzz.cpp reads them."""
    vertices, triangles = [], []
    for low, high in boxes:
        first = len(vertices)
        vertices += [[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]
        triangles += [[first + k for k in face] for face in ((0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
                                                              (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5))]
    return bytes([template, len(vertices) - 3]) + b"".join(struct.pack("<3h", *row) for row in vertices + triangles)


person = [((-180, 850, -100), (180, 1450, 100)), ((-90, 1400, -90), (90, 1750, 100)), ((150, 1300, -60), (800, 1420, 60)),
          ((-800, 1300, -60), (-150, 1420, 60)), ((20, 0, -80), (170, 900, 150)), ((-170, 0, -80), (-20, 900, 150))]
animal = [((-150, 500, -500), (150, 800, 500)), ((-80, 700, 450), (80, 1000, 750)), ((60, 0, 350), (150, 550, 450)),
          ((-150, 0, 350), (-60, 550, 450)), ((60, 0, -480), (150, 550, -380)), ((-150, 0, -480), (-60, 550, -380))]
SEEDS["rig_parts"] = [bytes([8 + k, 0, k]) + bytes((37 * i * (k + 1)) % 256 for i in range(200)) for k in range(3)]
SEEDS["rig"] = [boxes_to_rig(0, person), boxes_to_rig(1, person), boxes_to_rig(2, animal)]

data = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "data")
for file in sorted(os.listdir(data)):
    target = {"skel": "pinocchio_skeleton"}.get(file.split(".")[-1], file.split(".")[-1])
    if target in SEEDS:
        with open(os.path.join(data, file), "rb") as source:
            SEEDS[target].append(source.read())

for name, seeds in SEEDS.items():
    folder = os.path.join(sys.argv[1], name)
    os.makedirs(folder, exist_ok=True)
    for k, seed in enumerate(seeds):
        with open(os.path.join(folder, "seed%d" % k), "wb") as file:
            file.write(seed)
