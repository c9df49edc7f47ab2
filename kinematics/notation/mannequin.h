#pragma once

#include <string>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// The built-in figure: 53 joints and 13 fixed end sites (66 entries) of an adult 1.73 m tall. Metres, y up,
/// facing +z, the left side at +x; names end in _l and _r. docs/mannequin.md says where the figures come
/// from.
///
/// Frames at rest: z runs along the bone to the main child. Spine, neck and head: x to the left, so that a
/// turn about +x bends forwards. Legs: x to the left, y forwards (knee and ankle flex about +x, the hip about
/// -x). Clavicle and upper arm: a turn about +x raises the arm. Elbow: x is the unit normal of the plane
/// shoulder-elbow-wrist. Hand and fingers: a turn about +x curls towards the palm, y points out of the back
/// of the hand. Each right frame is the reflection of the left one at x = 0 with its x axis reversed: the
/// mirrored pose has equal angles about x and opposite ones about y and z.
///
/// Joints: Root is free; pelvis, spine, neck, head, clavicles, upper arms and thighs are balls with
/// swing-twist limits; knees, fingers and toes are hinges; elbows flex about x, then the forearm turns about
/// z; wrists, ankles, knuckles and thumb roots have two axes. Elbows, knees, thumbs and middle finger joints
/// stop 2 degrees short of straight. rest() is the relaxed pose in which the body is built (upper arm 49
/// degrees below horizontal, elbow flexed 47 degrees). The zero of a ball is the rest pose, except for
/// shoulders and hips, whose zero lies in the middle of their range, so that no swing within limits reaches
/// 150 degrees.
Skeleton mannequin();

/// The joints by which the figure is dragged: hands, feet, head and pelvis.
std::vector<std::string> mannequinHandles();

}  // namespace gelenk
