#include "skinning/bodies/mannequin_body.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>

#include "kinematics/symmetry.h"
#include "skinning/io/skin_cache.h"
#include "skinning/rigging/bone_heat.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Form = BodyPart::Form;

struct Triple {
  double x, y, z;
};

/// One part of the left side or of the middle; lengths of sections, blends and caps in millimetres, the axis
/// in metres.
struct Profile {
  std::string_view name, parent;
  Triple a, b, sectionUp;
  Form form;
  double blend, siblingBlend, capA, capB;
  std::vector<Section> sections;
};

// Measured on a CC0 body (MakeHuman hm08) by fitting all figures at once through the blend rule of BodyShape:
// rule, radii and figures belong together.
const std::vector<Profile>& profiles() {
  static const std::vector<Profile> table{
      {"torso",
       "",
       {0, 0.9314, 0.0031},
       {0, 1.484, 0.0115},
       {0, 0, 1},
       Form::Polar,
       0,
       0,
       71.2,
       49.1,
       {{0, 0, 16.9, 116.4, {-0.119, -0.014, 0.005, 0.057}},
        {0.08, 0, 29.3, 115.2, {-0.222, -0.008, 0.024, 0.023}},
        {0.17, 0, 37.8, 113.7, {-0.223, 0.016, 0.017, 0.004}},
        {0.27, 0, 34, 114.4, {-0.205, -0.011, -0.003, 0.019}},
        {0.38, 0, 30.7, 123.2, {-0.179, -0.016, -0.037, 0.005}},
        {0.49, 0, 25.2, 132.4, {-0.196, 0.016, -0.044, -0.01}},
        {0.6, 0, 20.3, 141, {-0.243, 0.038, -0.055, -0.034}},
        {0.71, 0, 11.9, 130, {-0.246, 0.076, -0.052, -0.038}},
        {0.81, 0, -1.2, 97.9, {-0.292, 0.205, 0.027, -0.05}},
        {0.89, 0, -7.4, 74.6, {-0.416, 0.195, 0.13, -0.075}}}},
      {"neck",
       "torso",
       {0, 1.484, 0.0115},
       {0, 1.5807, 0.0476},
       {0, 0, 1},
       Form::Polar,
       50,
       10,
       30.1,
       19.9,
       {{-0.3, 0, 19, 52.3, {-0.259, 0.022}},
        {0.1, 0, 12.9, 57.7, {-0.042, 0.059}},
        {0.5, 0, 11.5, 54.2, {0.053, 0.037}},
        {0.8, 0, 23.6, 62.3, {0.262, 0.043}}}},
      {"head",
       "neck",
       {0, 1.5807, 0.0476},
       {0, 1.7365, 0.0411},
       {0, 0, 1},
       Form::Inverse,
       30,
       5,
       14.6,
       73.9,
       {{-0.4, 0, 58.7, 27.5, {-0.302, 0.032, -0.094, -0.025}},
        {-0.22, 0, 38.7, 57.5, {-0.28, 0.037, -0.054, -0.004}},
        {0.06, 0, 13.5, 78.6, {-0.267, 0.04, 0.048, 0.044}},
        {0.5, 0, 2.7, 83, {-0.349, -0.053, 0.038, 0.032}}}},
      {"nose",
       "head",
       {0, 1.629, 0.131},
       {0, 1.588, 0.156},
       {0, 0, 1},
       Form::Inverse,
       18,
       4,
       10,
       9,
       {{0, 0, 0, 7, {-0.2}}, {0.35, 0, 0, 8.2, {-0.15}}, {0.7, 0, 0, 10, {0}}, {1, 0, 0, 10.5, {0.1}}}},
      {"pec_l",
       "torso",
       {0.03, 1.27, 0.09},
       {0.13, 1.31, 0.06},
       {0, 0, 1},
       Form::Polar,
       70,
       20,
       21.9,
       45.8,
       {{0.1, 5.2, -22.6, 16.8, {-0.252}, {0.344}},
        {0.5, 6.4, -0.8, 13.1, {0.015}, {0.108}},
        {0.9, 7.5, 20.7, 10.9, {0.319}, {-0.121}}}},
      {"glute_l",
       "torso",
       {0.078, 0.965, -0.03},
       {0.085, 0.885, -0.03},
       {0, 0, -1},
       Form::Polar,
       70,
       20,
       29.5,
       48.9,
       {{0.1, 1.2, 1.9, 24.1, {0.286}, {-0.238}},
        {0.5, 1.9, -1.4, 27.8, {0.334}, {0.167}},
        {0.9, -1.8, 1.3, 27.1, {0.47}, {0.579}}}},
      {"clav_l",
       "torso",
       {0.0228, 1.4096, 0.0223},
       {0.2035, 1.3795, 0.0183},
       {0, 0, 1},
       Form::Polar,
       80,
       20,
       48.3,
       51.1,
       {{0.3, 2.5, 7, 29.6, {0.289, -0.021}, {0.401, -0.155}},
        {0.65, 7.6, 0.5, 58.4, {0.136, -0.112}, {0.255, 0.047}},
        {0.95, 3.3, 6.4, 45.1, {0.166, -0.144}, {0.193, 0.103}}}},
      {"upperarm_l",
       "clav_l",
       {0.2035, 1.3795, 0.0183},
       {0.3657, 1.1908, 0.0156},
       {0, 0, 1},
       Form::Polar,
       60,
       10,
       40.3,
       21.4,
       {{-0.05, 31.9, -4.4, 51, {-0.43, 0.058}, {-0.057, -0.174}},
        {0.12, 4.6, -8.9, 45.8, {0.005, 0.012}, {-0.109, -0.065}},
        {0.3, 3.8, -9.3, 49.6, {0.056, 0.066}, {-0.074, 0.009}},
        {0.5, 4.9, -4.2, 48.3, {0.06, 0.064}, {-0.042, 0.013}},
        {0.7, 3.7, 1.5, 45.9, {0.093, 0.036}, {-0.07, -0.009}},
        {0.88, 6.9, 2.2, 37, {0.049, -0.008}, {-0.058, 0.005}},
        {1, 1.9, 4.2, 25.3, {0.057, -0.085}, {-0.079, 0.014}}}},
      {"lowerarm_l",
       "upperarm_l",
       {0.3657, 1.1908, 0.0156},
       {0.5003, 1.0621, 0.2076},
       {0, 1, 0},
       Form::Polar,
       40,
       10,
       32,
       15.6,
       {{0, 15.5, 14.7, 31.8, {0.185, -0.002}, {0.099, 0.113}},
        {0.12, 9, 7, 38.9, {0.069, 0.058}, {-0.005, 0.032}},
        {0.28, 7, 3.9, 40.6, {0.007, 0.044}, {-0.023, 0.015}},
        {0.48, 2.9, 1, 35.6, {-0.019, 0.04}, {-0.036, 0.002}},
        {0.7, 0.7, 0.6, 30.3, {-0.037, 0.007}, {-0.006, 0.001}},
        {0.88, -0, 0.1, 23.6, {-0.032, -0.048}, {0.075, 0.035}},
        {1, -0.4, 0.3, 12.7, {-0.009, -0.082}, {0.066, 0.051}}}},
      {"palm_l",
       "lowerarm_l",
       {0.5003, 1.0621, 0.2076},
       {0.5485, 1.0086, 0.2941},
       {0.748, 0.663, -0.007},
       Form::Polar,
       25,
       10,
       24.3,
       10.1,
       {{0, -1.4, -1.7, 18.1, {-0.341, -0.049, 0.016}, {0.092, 0.021, -0.016}},
        {0.22, -3.8, -4.1, 26, {-0.231, 0.014, 0.013}, {0.089, -0, -0.012}},
        {0.46, -7.2, -4.4, 25.8, {-0.346, 0.092, 0.036}, {0.101, -0.012, -0.03}},
        {0.7, -3, -5.6, 24.9, {-0.535, 0.122, 0.1}, {0.04, 0.022, -0.035}},
        {0.92, 3.2, -10.4, 22.6, {-0.432, 0.042, 0.15}, {-0.01, 0.022, -0.011}}}},
      {"index_01_l",
       "palm_l",
       {0.5305, 1.0214, 0.3129},
       {0.5341, 1.0057, 0.3363},
       {0.748, 0.663, -0.007},
       Form::Polar,
       12,
       2,
       7.7,
       6.1,
       {{0, -1.5, -6, 9.2, {-0.05}, {0.032}},
        {0.5, -0.6, -6.2, 10.6, {-0.031}, {-0.027}},
        {0.95, -0.3, -5.6, 9.5, {-0.013}, {-0.034}}}},
      {"index_02_l",
       "index_01_l",
       {0.5341, 1.0057, 0.3363},
       {0.5336, 0.9885, 0.355},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6.1,
       6,
       {{0.05, -1.1, -4.8, 9.3, {-0.057}, {-0.005}},
        {0.5, -0.7, -5.3, 10.3, {-0.031}, {-0.009}},
        {0.95, -0.5, -4.9, 8.7, {-0.065}, {-0.022}}}},
      {"index_03_l",
       "index_02_l",
       {0.5336, 0.9885, 0.355},
       {0.5298, 0.9675, 0.3749},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6,
       5.8,
       {{0.1, -0.3, -3.2, 8.4, {-0.066}, {-0.017}},
        {0.5, -0.4, -2.7, 8.2, {-0.112}, {-0.049}},
        {0.8, -0.4, -1.7, 6.8, {-0.1}, {-0.07}}}},
      {"middle_01_l",
       "palm_l",
       {0.5485, 1.0086, 0.2941},
       {0.5564, 0.9811, 0.3175},
       {0.748, 0.663, -0.007},
       Form::Polar,
       12,
       2,
       7.5,
       6.1,
       {{0, 1.1, -9.5, 9.9, {0.224}, {-0.109}},
        {0.5, 1, -8.1, 11.4, {0.039}, {-0.003}},
        {0.95, 0.9, -5.9, 10, {-0.03}, {0.001}}}},
      {"middle_02_l",
       "middle_01_l",
       {0.5564, 0.9811, 0.3175},
       {0.5594, 0.9584, 0.3371},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6,
       6.1,
       {{0.05, 1, -5.6, 9.1, {-0.04}, {0.015}},
        {0.5, 1, -5.9, 9.9, {-0.044}, {0.006}},
        {0.95, 0.9, -5, 8.3, {-0.079}, {0.008}}}},
      {"middle_03_l",
       "middle_02_l",
       {0.5594, 0.9584, 0.3371},
       {0.5592, 0.9344, 0.3542},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6,
       5.2,
       {{0.1, 0.5, -3.6, 7.8, {-0.029}, {0.006}},
        {0.5, 0.7, -2.5, 7.9, {-0.092}, {-0.017}},
        {0.8, 0.8, -1.1, 6.8, {-0.096}, {-0.015}}}},
      {"ring_01_l",
       "palm_l",
       {0.5569, 0.9997, 0.2755},
       {0.5671, 0.9735, 0.2919},
       {0.748, 0.663, -0.007},
       Form::Polar,
       12,
       2,
       8.9,
       6.2,
       {{0, -1.3, -4.7, 5.6, {0.176}, {-0.167}},
        {0.5, -0.2, -6.3, 9.8, {0.013}, {-0.003}},
        {0.95, 0.3, -6.2, 9.1, {-0.037}, {0.049}}}},
      {"ring_02_l",
       "ring_01_l",
       {0.5671, 0.9735, 0.2919},
       {0.5718, 0.9511, 0.3067},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6.1,
       5.9,
       {{0.05, -0.1, -4.6, 8, {-0.065}, {0.036}},
        {0.5, -0.3, -5.2, 8.9, {-0.037}, {0.017}},
        {0.95, -0.5, -5.1, 7.7, {-0.073}, {-0.001}}}},
      {"ring_03_l",
       "ring_02_l",
       {0.5718, 0.9511, 0.3067},
       {0.5743, 0.9252, 0.3198},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       5.9,
       6.2,
       {{0.1, -0.6, -3.8, 7.5, {-0.07}, {-0.031}},
        {0.5, -0.2, -2.6, 7.9, {-0.098}, {-0.016}},
        {0.8, 0, -0.9, 6.8, {-0.11}, {-0.015}}}},
      {"pinky_01_l",
       "palm_l",
       {0.5584, 0.9893, 0.2545},
       {0.5649, 0.9688, 0.2635},
       {0.748, 0.663, -0.007},
       Form::Polar,
       12,
       2,
       8.2,
       6.1,
       {{0, -1.1, -5.7, 9.6, {0.101}, {0.119}},
        {0.5, -0.8, -4.2, 8, {0.02}, {0.045}},
        {0.95, -0.4, -3.2, 7.9, {-0.004}, {0.046}}}},
      {"pinky_02_l",
       "pinky_01_l",
       {0.5649, 0.9688, 0.2635},
       {0.5668, 0.9533, 0.2703},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6,
       6.2,
       {{0.05, 0.2, -2.4, 4.9, {-0.008}, {-0.072}},
        {0.5, -0.1, -2.6, 7.2, {-0.019}, {-0.019}},
        {0.95, -0.3, -2.6, 5.9, {-0.045}, {0.02}}}},
      {"pinky_03_l",
       "pinky_02_l",
       {0.5668, 0.9533, 0.2703},
       {0.5696, 0.9334, 0.2787},
       {0.748, 0.663, -0.007},
       Form::Polar,
       6,
       2,
       6,
       5.6,
       {{0.1, -0.4, -2.2, 5.9, {-0.058}, {0.003}},
        {0.5, -0.2, -2.2, 6.5, {-0.074}, {-0.001}},
        {0.8, -0, -2.1, 5.4, {-0.074}, {0.003}}}},
      {"thumb_01_l",
       "palm_l",
       {0.5015, 1.0554, 0.2563},
       {0.4787, 1.0469, 0.2797},
       {-0.93, 0.346, -0.122},
       Form::Polar,
       20,
       4,
       11.5,
       6.5,
       {{0, 6.2, 2.8, 18.6, {-0.006}, {0.008}},
        {0.45, 4.5, -0.6, 21.1, {0.054}, {0.04}},
        {0.95, 2.3, -5, 17.9, {0.17}, {0.039}}}},
      {"thumb_02_l",
       "thumb_01_l",
       {0.4787, 1.0469, 0.2797},
       {0.4651, 1.0329, 0.3145},
       {-0.93, 0.346, -0.122},
       Form::Polar,
       8,
       2,
       7.9,
       8.3,
       {{0.05, 1.5, -2.2, 12, {0.022}, {-0.024}},
        {0.5, 2, -3.4, 11.2, {0.051}, {0.029}},
        {0.95, 2.5, -3.7, 9.6, {0.089}, {0.011}}}},
      {"thumb_03_l",
       "thumb_02_l",
       {0.4651, 1.0329, 0.3145},
       {0.4591, 1.0149, 0.3382},
       {-0.93, 0.346, -0.122},
       Form::Polar,
       6,
       2,
       6,
       7.1,
       {{0.1, 4.1, -4, 9.2, {0.039}, {0.07}},
        {0.5, 3.1, -3.1, 9.4, {0.024}, {0.205}},
        {0.8, 1.6, -1.3, 7.9, {0.01}, {0.258}}}},
      {"thigh_l",
       "torso",
       {0.1085, 0.9261, -0.0076},
       {0.148, 0.51, 0.0269},
       {0, 0, 1},
       Form::Polar,
       80,
       20,
       48.6,
       54.8,
       {{-0.12, 55.2, 14.8, 53.6, {0.394, -0.002, 0.016}, {0.235, 0.134, -0.059}},
        {0.04, 31.7, 12.4, 78, {0.142, -0.031, -0.023}, {-0.05, -0.005, -0.024}},
        {0.18, 18.4, 21.1, 84.7, {0.05, -0.004, 0.009}, {-0.042, -0.018, 0.009}},
        {0.32, 13.1, 25.7, 86.3, {0.015, 0.006, 0.007}, {-0.035, -0.017, 0.019}},
        {0.47, 9.1, 24.5, 84.7, {0.003, 0.007, 0.013}, {-0.021, -0.029, 0.007}},
        {0.63, 7.3, 20.5, 77.7, {0.006, -0.006, -0.002}, {-0.029, -0.017, 0.018}},
        {0.8, 8.3, 10.8, 60.8, {0.023, 0.053, 0.01}, {-0.061, -0.021, 0.004}},
        {0.92, 6.3, 2.2, 45.2, {0.111, 0.137, 0.037}, {-0.132, -0.06, -0.012}},
        {1.02, -3.6, -17.4, 35.4, {0.099, 0.043, 0.037}, {-0.035, -0.092, -0.014}}}},
      {"calf_l",
       "thigh_l",
       {0.148, 0.51, 0.0269},
       {0.1978, 0.0715, 0.0152},
       {0, 0, 1},
       Form::Polar,
       60,
       10,
       60,
       28.6,
       {{-0.02, -0.9, -5, 35.7, {0.062, 0.046, 0.052}, {0.191, -0.143, -0.014}},
        {0.1, -14.3, -27.3, 47.5, {0.068, 0.042, 0.041}, {-0.021, -0.051, -0.006}},
        {0.22, -13.4, -28.8, 59.5, {0.017, 0.009, 0.028}, {-0.008, -0.029, -0.014}},
        {0.36, -10.9, -27.6, 60.2, {-0.008, -0.002, 0.015}, {-0.002, -0.03, -0.013}},
        {0.52, -10.4, -22.4, 51.9, {-0.002, 0.005, 0.003}, {0.006, -0.033, -0.012}},
        {0.7, -9.3, -15.4, 39.6, {0.075, -0.008, -0.001}, {-0.021, -0.002, -0.011}},
        {0.86, -7.9, -8.7, 32.7, {0.195, 0.008, 0.019}, {-0.04, 0.046, -0.002}},
        {1, -6.5, 7, 29.8, {0.144, 0.047, 0.003}, {0.058, 0.004, 0.019}}}},
      {"foot_l",
       "calf_l",
       {0.1978, 0.0358, 0.0152},
       {0.1976, 0.014, 0.2117},
       {0, 1, 0},
       Form::Inverse,
       30,
       10,
       13.3,
       11.8,
       {{-0.24, 0.3, -4.2, 25.7, {-0.578, -0.25, 0.009}, {0.026, -0.026, 0.003}},
        {-0.1, -2.4, 0.9, 34.3, {-0.48, -0.217, 0.021}, {0.034, -0.01, 0.006}},
        {0.08, -5.1, 6.6, 35.5, {-0.243, -0.179, 0.022}, {-0.101, -0.002, -0}},
        {0.25, -6.4, 10, 34.2, {-0, -0.167, 0.018}, {-0.287, -0.007, -0.011}},
        {0.42, -4.3, 5.9, 30.5, {0.383, -0.161, 0.016}, {-0.352, -0.053, -0.018}},
        {0.6, 4.1, -1.2, 27.2, {0.637, -0.109, 0.019}, {-0.112, -0.137, -0.017}},
        {0.78, 13.6, -0.2, 16.9, {0.703, -0.029, 0.018}, {-0.032, -0.196, -0.005}}}},
  };
  return table;
}

/// What makes a face, an ear and a foot of the measured shapes, by eye: the hull of two balls, joined to its
/// parent or carved out of it. Radii and blends in millimetres, ends in metres.
struct Detail {
  std::string_view name, parent;
  Triple a, b;
  double radiusA, radiusB, blend, siblingBlend;
  bool carved = false;
  double flatness = 1.0;
  Triple flat = {0, 0, 1};
};

constexpr Triple earOut{0.902, 0, 0.432};  // away from the head and a little forwards
constexpr Detail details[] = {
    {"chin", "head", {0.006, 1.521, 0.132}, {-0.006, 1.521, 0.132}, 17, 17, 22, 6},
    {"sulcus", "head", {0.012, 1.5375, 0.1625}, {-0.012, 1.5375, 0.1625}, 10, 10, 12, 6, true},
    {"brow_l", "head", {0.0150, 1.6380, 0.1355}, {0.0440, 1.6370, 0.1245}, 8, 6.5, 16, 6},
    {"socket_l", "head", {0.0200, 1.6200, 0.1490}, {0.0430, 1.6190, 0.1405}, 13, 11, 10, 5, true},
    {"eye_l", "head", {0.0308, 1.6190, 0.1272}, {0.0322, 1.6190, 0.1272}, 12.5, 12.5, 5, 2},
    {"lid_1_l", "eye_l", {0.0214, 1.6177, 0.1348}, {0.0277, 1.6144, 0.1384}, 1.6, 1.9, 1.5, 3, true},
    {"lid_2_l", "eye_l", {0.0277, 1.6144, 0.1384}, {0.0363, 1.6144, 0.1380}, 1.9, 1.9, 1.5, 3, true},
    {"lid_3_l", "eye_l", {0.0363, 1.6144, 0.1380}, {0.0424, 1.6187, 0.1338}, 1.9, 1.6, 1.5, 3, true},
    {"wing_l", "head", {0.0115, 1.5865, 0.1490}, {0.0110, 1.5860, 0.1460}, 5.5, 6, 8, 5},
    {"nostril_l", "nose", {0.0055, 1.5775, 0.1590}, {0.0060, 1.5790, 0.1540}, 2.8, 3.2, 3, 2, true},
    {"lip_1_l", "head", {0.0025, 1.5606, 0.1554}, {0.0120, 1.5592, 0.1540}, 4.0, 3.5, 4, 1},
    {"lip_2_l", "head", {0.0120, 1.5592, 0.1540}, {0.0240, 1.5557, 0.1478}, 3.5, 2.0, 4, 1},
    {"lip_3_l", "head", {-0.0030, 1.5487, 0.1546}, {0.0110, 1.5500, 0.1530}, 4.6, 4.0, 4, 1},
    {"lip_4_l", "head", {0.0110, 1.5500, 0.1530}, {0.0230, 1.5545, 0.1480}, 4.0, 2.2, 4, 1},
    {"ear_stem_l", "head", {0.0690, 1.6090, 0.0370}, {0.0690, 1.5920, 0.0410}, 9, 8, 6, 3},
    {"lips_l", "head", {-0.0020, 1.5550, 0.1600}, {0.0255, 1.5550, 0.1512}, 2.6, 2.0, 1.5, 1, true},
    {"ear_l",
     "head",
     {0.0760, 1.6120, 0.0370},
     {0.0745, 1.5920, 0.0420},
     18,
     12.5,
     7,
     2,
     false,
     0.30,
     earOut},
    {"concha_l",
     "ear_l",
     {0.0835, 1.6120, 0.0400},
     {0.0815, 1.5940, 0.0440},
     12,
     8.5,
     2.5,
     1,
     true,
     0.55,
     earOut},
    {"fold_l", "ear_l", {0.0785, 1.6150, 0.0350}, {0.0790, 1.5950, 0.0360}, 3.2, 2.4, 4, 2},
    {"tragus_l", "ear_l", {0.0735, 1.6010, 0.0530}, {0.0730, 1.5970, 0.0525}, 3.6, 3.6, 4, 2},
    {"lobe_l", "ear_l", {0.0745, 1.5800, 0.0430}, {0.0745, 1.5830, 0.0430}, 5.5, 6.0, 8, 2},
    {"hip_l", "torso", {0.1120, 0.9680, 0.0200}, {0.1210, 0.9350, 0.0250}, 32, 34, 40, 30},
    {"toe_1_l", "foot_l", {0.1660, 0.0150, 0.1700}, {0.1700, 0.0125, 0.1985}, 12.5, 11.0, 12, 1.5},
    {"toe_2_l", "foot_l", {0.1860, 0.0130, 0.1700}, {0.1890, 0.0105, 0.2025}, 8.0, 7.0, 10, 1.5},
    {"toe_3_l", "foot_l", {0.1990, 0.0125, 0.1650}, {0.2025, 0.0100, 0.1945}, 7.5, 6.6, 10, 1.5},
    {"toe_4_l", "foot_l", {0.2110, 0.0120, 0.1580}, {0.2150, 0.0095, 0.1845}, 7.2, 6.3, 10, 1.5},
    {"toe_5_l", "foot_l", {0.2210, 0.0115, 0.1490}, {0.2260, 0.0092, 0.1720}, 7.2, 6.2, 10, 1.5},
};

Vector3d vector(const Triple& t) { return {t.x, t.y, t.z}; }

BodyPart partOf(const Detail& detail, int parent) {
  constexpr double millimetre = 1e-3;
  return {.parent = parent,
          .blend = detail.blend * millimetre,
          .siblingBlend = detail.siblingBlend * millimetre,
          .carved = detail.carved,
          .a = vector(detail.a),
          .b = vector(detail.b),
          .radiusA = detail.radiusA * millimetre,
          .radiusB = detail.radiusB * millimetre,
          .flatness = detail.flatness,
          .flat = vector(detail.flat).normalized()};
}

BodyPart partOf(const Profile& profile, int parent) {
  constexpr double millimetre = 1e-3;
  BodyPart part{.form = profile.form,
                .parent = parent,
                .blend = profile.blend * millimetre,
                .siblingBlend = profile.siblingBlend * millimetre,
                .a = vector(profile.a),
                .b = vector(profile.b),
                .sectionUp = vector(profile.sectionUp),
                .sections = profile.sections,
                .capA = profile.capA * millimetre,
                .capB = profile.capB * millimetre};
  for (Section& section : part.sections) {
    section.u *= millimetre;
    section.v *= millimetre;
    section.radius *= millimetre;
  }
  return part;
}

std::string rightName(std::string_view name) {
  return name.ends_with("_l") ? std::string(name.substr(0, name.size() - 1)) + "r" : std::string(name);
}

/// Raise it when the polygoniser, the weights or what follows them change their result.
constexpr double methodVersion = 2.0;

/// The torso is wide and its joints lie in the middle: without ribs the flank would follow the arm, whose
/// bone is nearer. Stand-ins for rib cage and pelvis, carried by the joints of the spine. Metres, left side.
struct Rib {
  std::string_view joint;
  Triple from, to;
};
constexpr Rib ribs[] = {
    {"pelvis", {0.09, 0.93, 0.0}, {0.08, 1.01, 0.0}},
    {"spine_01", {0.08, 1.03, 0.0}, {0.08, 1.07, 0.0}},
    {"spine_02", {0.085, 1.09, 0.0}, {0.09, 1.13, 0.0}},
    {"spine_03", {0.095, 1.15, 0.0}, {0.105, 1.30, 0.0}},
    {"spine_03", {0.07, 1.20, 0.07}, {0.09, 1.30, 0.07}},
    {"spine_03", {0.07, 1.20, -0.07}, {0.08, 1.36, -0.06}},
};

std::vector<Bone> weightBones(const Skeleton& mannequin, const Frames& rest) {
  std::vector<Bone> bones = bonesOf(mannequin, rest);
  for (const Rib& rib : ribs)
    for (const double side : {1.0, -1.0}) {
      const Vector3d from = vector(rib.from), to = vector(rib.to);
      bones.push_back({mannequin.jointIndex(rib.joint),
                       {side * from.x(), from.y(), from.z()},
                       {side * to.x(), to.y(), to.z()}});
    }
  return bones;
}

/// Rounding and the order of elimination leave left and right 1e-12 apart: the right side takes over the left
/// side's weights, and vertices in the plane of symmetry the mean of theirs and their image's.
void makeSymmetric(SparseWeights& weights, const std::vector<int>& vertexPartner,
                   const std::vector<int>& jointPartner) {
  for (std::size_t v = 0; v < weights.size(); ++v) {
    const auto image = static_cast<std::size_t>(vertexPartner[v]);
    if (image < v) continue;
    std::map<int, double> sum;
    for (const auto& [joint, w] : weights[v]) {
      sum[joint] += image == v ? 0.5 * w : w;
      if (image == v) sum[jointPartner[joint]] += 0.5 * w;
    }
    weights[v].assign(sum.begin(), sum.end());
    if (image == v) {  // of the four that will be kept none may lack its image: better three
      auto& row = weights[v];
      std::stable_sort(row.begin(), row.end(),
                       [](const auto& a, const auto& b) { return a.second > b.second; });
      if (row.size() > 4 && row[3].first != jointPartner[row[3].first] &&
          row[4].first == jointPartner[row[3].first])
        row.resize(3);
      continue;
    }
    weights[image].clear();
    for (const auto& [joint, w] : sum) weights[image].emplace_back(jointPartner[joint], w);
  }
}

}  // namespace

BodyShape mannequinShape() {
  std::vector<BodyPart> parts;
  std::unordered_map<std::string, int> index{{"", -1}};
  const auto append = [&](const std::string& name, BodyPart part) {
    index[name] = static_cast<int>(parts.size());
    parts.push_back(std::move(part));
  };
  const auto appendBoth = [&](const auto& part) {
    append(std::string(part.name), partOf(part, index.at(std::string(part.parent))));
    if (!part.name.ends_with("_l")) return;
    BodyPart right = partOf(part, index.at(rightName(part.parent)));
    right.mirrored = true;
    append(rightName(part.name), std::move(right));
  };
  for (const Profile& profile : profiles()) appendBoth(profile);
  for (const Detail& detail : details) appendBoth(detail);
  return BodyShape(std::move(parts));
}

PolygoniseOptions mannequinGrid() {
  const GridLens hands{{{0.545, 1.0, 0.29}, {-0.545, 1.0, 0.29}}, 3.2, 0.28};
  const GridLens head{{{0.0, 1.63, 0.06}}, 1.3, 0.30};
  const GridLens feet{{{0.2, 0.04, 0.08}, {-0.2, 0.04, 0.08}}, 1.5, 0.25};
  const GridLens face{{{0.0, 1.59, 0.14}}, 2.6, 0.09};
  const GridLens mouth{{{0.0, 1.562, 0.157}}, 3.0, 0.040};
  const GridLens eyes{{{0.031, 1.619, 0.137}, {-0.031, 1.619, 0.137}}, 3.2, 0.028};
  const GridLens ears{{{0.079, 1.603, 0.036}, {-0.079, 1.603, 0.036}}, 4.5, 0.045};
  const GridLens toes{{{0.195, 0.012, 0.19}, {-0.195, 0.012, 0.19}}, 2.1, 0.07};
  return {.cell = 0.0187, .lenses = {hands, head, feet, face, mouth, eyes, ears, toes}, .symmetric = true};
}

Skin makeMannequinSkin(const Skeleton& mannequin, WeightLoss* loss) {
  std::vector<int> partner;
  Mesh mesh = polygonise(mannequinShape(), mannequinGrid(), &partner);
  const Frames rest = restFrames(mannequin);
  SparseWeights weights = boneHeatWeights(mesh, weightBones(mannequin, rest), {.strength = 6.0});
  makeSymmetric(weights, partner, mirrorPartners(mannequin));
  std::vector<Influences> influences = fourLargest(weights, mannequin.jointCount(), loss);
  return bindSkin(std::move(mesh), rest, std::move(influences));
}

std::uint64_t mannequinSkinKey(const Skeleton& mannequin) {
  std::vector<double> facts{methodVersion, mannequinGrid().cell};
  const auto add = [&](const Vector3d& p) { facts.insert(facts.end(), {p.x(), p.y(), p.z()}); };
  for (const auto& frame : restFrames(mannequin))
    add(frame.translation()), add(frame.linear().col(0)), add(frame.linear().col(2));
  for (const GridLens& lens : mannequinGrid().lenses) {
    facts.insert(facts.end(), {lens.magnification, lens.reach});
    for (const Vector3d& c : lens.centres) add(c);
  }
  const BodyShape shape = mannequinShape();
  for (const BodyPart& part : shape.parts()) {
    add(part.a), add(part.b), add(part.sectionUp);
    add(part.flat);
    facts.insert(facts.end(),
                 {part.blend, part.siblingBlend, part.capA, part.capB, part.radiusA, part.radiusB,
                  part.flatness, part.carved ? 1.0 : 0.0, static_cast<double>(part.form)});
    for (const Section& s : part.sections) {
      facts.insert(facts.end(), {s.at, s.u, s.v, s.radius});
      for (int n = 0; n < 4; ++n) facts.insert(facts.end(), {s.cosine[n], s.sine[n]});
    }
  }
  return checksum({reinterpret_cast<const char*>(facts.data()), facts.size() * sizeof(double)});
}

}  // namespace gelenk
