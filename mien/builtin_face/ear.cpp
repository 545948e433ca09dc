#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"

namespace mien::builtin_face {

void add_ear(Sculpt& half) {
  const Vec3 root(76.8, 14, -1);
  const Vec3 back = Vec3(0.50, 0.06, -0.86).normalized();
  const Vec3 up = (Vec3(0.05, 1, -0.16) - Vec3(0.05, 1, -0.16).dot(back) * back).normalized();
  const Vec3 out = up.cross(back).normalized() * -1.0;
  constexpr int kAround = 28;
  const auto place = [&](double rho, double phi, double depth) {
    // phi 0 points back, 90 degrees up.
    const double c = std::cos(phi), s = std::sin(phi);
    // Widest above the middle, narrow at the lobe.
    const double reach_back = mix(21, 15.5, smoothstep(0.25, -0.95, s));
    const double across = c > 0 ? reach_back : 9.5;
    const double along = s > 0 ? 30 : 27;
    return Vec3(root + back * (rho * across * c + 2.0 + 4.0 * s * (s > 0 ? 0.6 : -0.2)) +
                up * (rho * along * s + 3) + out * depth);
  };
  const auto relief = [](double rho, double phi) {
    const double s = std::sin(phi), c = std::cos(phi);
    const double front = smoothstep(0.3, 0.9, -c);  // toward the face
    const double lobe = smoothstep(-0.55, -0.9, s);
    const double rim = (1 - lobe) * (1 - 0.6 * front);
    double h = 4.2;
    // Helix, the groove beside it, and the antihelix, which parts in two legs above; the concha is deep.
    const double legs = smoothstep(0.2, 0.8, s);
    h += rim * (3.8 * gauss((rho - 0.92) / 0.09) - 3.4 * gauss((rho - 0.77) / 0.09));
    h += (1 - lobe) * (1 - front) * mix(4.2, 2.8, legs) * gauss((rho - 0.58) / 0.10);
    h += legs * (1 - lobe) * 2.0 * gauss((rho - 0.36) / 0.10) * gauss((c + 0.1) / 0.5);
    h -= 8.4 * gauss(rho / 0.38) * (1 - 0.3 * lobe);
    h += 5.0 * gauss((rho - 0.60) / 0.20) * front * gauss((s + 0.1) / 0.45);  // tragus
    h -= 3.0 * smoothstep(0.8, 1.0, rho) * front;                             // sinks into the cheek
    return h;
  };
  // Front and back of the ear in one disc of the texture, the front inside.
  constexpr double kFrontOfChart = 0.6;
  const auto add = [&](double rho, double phi, double depth, double from_middle) {
    SculptVertex v = vertex(place(rho, phi, depth), Tissue::ear);
    v.chart = {from_middle, phi};
    return half.add(v);
  };
  Ring ring;
  const double rhos[] = {1.0, 0.93, 0.86, 0.78, 0.69, 0.6, 0.5, 0.39, 0.26, 0.12};
  for (const double rho : rhos) {
    Ring next;
    for (int i = 0; i < kAround; ++i) {
      const double phi = 2 * M_PI * i / kAround;
      next.push_back(add(rho, phi, relief(rho, phi), kFrontOfChart * rho));
    }
    if (!ring.empty()) sew(half, Piece::ears, ring, next, true);
    ring = std::move(next);
  }
  const std::uint32_t bottom = add(0, 0, relief(0, 0), 0);
  for (int i = 0; i < kAround; ++i) half.triangle(Piece::ears, ring[i], ring[(i + 1) % kAround], bottom);
  // The back: from the rim inwards to a stem that ends inside the head.
  ring.clear();
  for (int i = 0; i < kAround; ++i)
    ring.push_back(static_cast<std::uint32_t>(bottom - kAround * std::size(rhos) + i));
  const double backs[][3] = {
      {1.02, 2.0, 0.64}, {0.95, -0.5, 0.69}, {0.7, -4.0, 0.80}, {0.45, -10.0, 0.91}, {0.4, -20.0, 1.0}};
  for (const auto& b : backs) {
    Ring next;
    for (int i = 0; i < kAround; ++i) next.push_back(add(b[0], 2 * M_PI * i / kAround, b[1], b[2]));
    sew(half, Piece::ears, next, ring, true);
    ring = std::move(next);
  }
}

}  // namespace mien::builtin_face
