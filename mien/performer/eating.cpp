#include "mien/performer/eating.h"

#include <algorithm>

#include "mien/core/units.h"

namespace mien::performer {

namespace {

/// How often a person chews, cycles a second.
constexpr double kPaceHz = 1.57, kPaceSpreadHz = 0.25, kSlowestHz = 1.0, kFastestHz = 2.1;

/// The side that the food is on.
enum class Side { left, right };

/// One person's meal, laid down from its beginning to its end.
class Meal {
 public:
  Meal(Canvas& canvas, const Style& style, Random random) : canvas_(canvas), random_(random) {
    // The pace is the person's, whatever the meal (Po et al. 2011).
    Random person = Random(style.taste).fork("chewing");
    pace_hz_ = std::clamp(person.normal(kPaceHz, kPaceSpreadHz), kSlowestHz, kFastestHz);
    favourite_ = person.chance(0.5) ? Side::left : Side::right;
  }

  void eat() {
    double now_s = random_.uniform(0, 0.5);
    while (now_s < canvas_.duration_s()) {
      if (random_.chance(0.3)) {
        now_s = drink(now_s);
      } else {
        now_s = take_mouthful(now_s);
        now_s = chew(now_s);
        now_s = swallow(now_s);
        if (random_.chance(0.15)) now_s = lick(now_s);
      }
      canvas_.pauses_s.push_back(now_s);
      now_s += random_.uniform(0.2, 1.5);
    }
  }

 private:
  void add(std::string_view name, const Envelope& envelope, double peak) {
    canvas_.add(pose_of({{name, 1}}), envelope, peak);
  }
  /// Lips that meet for a while, whatever the jaw does.
  void close_lips(const Envelope& envelope) {
    for_frames(envelope, [&](std::size_t i, double share) {
      canvas_.lip_closure[i] = std::max(canvas_.lip_closure[i], static_cast<float>(share));
    });
  }
  /// `pitch_rad`: down is positive.
  void lean(const Envelope& envelope, double pitch_rad) {
    const double aside = 0.1 * random_.normal();
    for_frames(envelope, [&](std::size_t i, double share) {
      canvas_.head_rad[i] += share * pitch_rad * Vec3(1, aside, 0.5 * aside);
    });
  }
  void look(const Envelope& envelope, double pitch_up_rad) {
    for_frames(envelope, [&](std::size_t i, double share) {
      canvas_.gaze_rad[i].y() += static_cast<float>(share * pitch_up_rad);
      canvas_.gaze_held[i] = std::max(canvas_.gaze_held[i], static_cast<float>(share));
    });
  }
  template <class Each>
  void for_frames(const Envelope& envelope, Each&& each) {
    for (std::size_t i = 0; i < canvas_.frame_count(); ++i)
      if (const double share = envelope.at(static_cast<double>(i) / kFrameRateHz); share > 0) each(i, share);
  }

  /// The hand comes to the mouth, which opens, takes what it holds, and wipes it off with the lips.
  double take_mouthful(double begin_s) {
    const double comes_s = random_.uniform(0.4, 0.9);
    const double opens_s = random_.uniform(0.25, 0.45), open_s = random_.uniform(0.1, 0.4);
    const double bites_s = random_.uniform(0.18, 0.35);
    look({begin_s, 0.15, comes_s, 0.3}, -random_.uniform(15, 28) * kRadPerDeg);
    lean({begin_s, comes_s, opens_s + open_s, 0.6}, random_.uniform(3, 10) * kRadPerDeg);
    const Envelope mouth{begin_s + comes_s, opens_s, open_s, bites_s};
    const double opening = random_.uniform(0.35, 0.8);
    add("jawOpen", mouth, opening);
    add("mouthUpperUp", mouth, 0.4 * opening * random_.uniform(0.3, 1));
    add("mouthLowerDown", mouth, 0.4 * opening * random_.uniform(0.3, 1));
    add("mouthFunnel", mouth, random_.uniform(0, 0.25));
    const double shut_s = mouth.end_s();
    const Envelope wipe{shut_s - 0.06, 0.12, random_.uniform(0.05, 0.25), 0.25};
    add("mouthPress", wipe, random_.uniform(0.25, 0.6));
    add("mouthRollLower", wipe, random_.uniform(0.05, 0.3));
    add("mouthRollUpper", wipe, random_.uniform(0.0, 0.2));
    return shut_s + 0.1;
  }

  /// Some seconds of chewing behind closed lips (13 s on average: Po et al. 2011).
  double chew(double begin_s) {
    const double length_s = std::clamp(13.0 * random_.log_normal(0.5), 3.0, 30.0);
    Side side = random_.chance(0.8) ? favourite_ : other(favourite_);
    const double size = random_.uniform(0.7, 1.3);
    const double end_s = begin_s + length_s;
    close_lips({begin_s - 0.1, 0.15, length_s, 0.2});
    bulge(side, begin_s, length_s);
    double now_s = begin_s;
    while (now_s < end_s) {
      // Food gets softer: from the first cycle to the last by about half.
      const double softer = 1 - 0.5 * (now_s - begin_s) / length_s;
      now_s += chew_once(side, now_s, size * softer);
      if (random_.chance(0.06)) side = other(side);
    }
    return std::max(now_s, end_s);
  }

  /// One round of the jaw. Gives its length.
  double chew_once(Side side, double begin_s, double size) {
    const double period_s = random_.log_normal(0.08) / pace_hz_;
    const double opening = size * random_.uniform(0.14, 0.32);
    add("jawOpen", {begin_s, 0.40 * period_s, 0.04 * period_s, 0.46 * period_s}, opening);
    // On its way up the jaw comes from the side that chews, and crosses a little to the other.
    const std::string_view there = side == Side::left ? "jawLeft" : "jawRight";
    const std::string_view across = side == Side::left ? "jawRight" : "jawLeft";
    add(there, {begin_s + 0.22 * period_s, 0.30 * period_s, 0, 0.36 * period_s},
        size * random_.uniform(0.12, 0.36));
    add(across, {begin_s + 0.80 * period_s, 0.15 * period_s, 0, 0.20 * period_s},
        size * random_.uniform(0, 0.08));
    const Envelope crush{begin_s + 0.62 * period_s, 0.22 * period_s, 0.06 * period_s, 0.28 * period_s};
    add("mouthPress", crush, size * random_.uniform(0.1, 0.35));
    add("mouthShrugLower", crush, size * random_.uniform(0.05, 0.25));
    add(side == Side::left ? "mouthDimple_L" : "mouthDimple_R", crush, size * random_.uniform(0.05, 0.25));
    add(side == Side::left ? "cheekSquint_L" : "cheekSquint_R", crush, size * random_.uniform(0.02, 0.12));
    add("mouthPucker", {begin_s, 0.45 * period_s, 0, 0.5 * period_s}, size * random_.uniform(0, 0.15));
    return period_s;
  }

  /// The food stands in the cheek, and draws the mouth over.
  void bulge(Side side, double begin_s, double length_s) {
    const Envelope whole{begin_s, 0.5, 0.6 * length_s, 0.4 * length_s};
    add(side == Side::left ? "cheekPuff_L" : "cheekPuff_R", whole, random_.uniform(0.03, 0.2));
    add(side == Side::left ? "mouthLeft" : "mouthRight", whole, random_.uniform(0, 0.12));
  }

  double swallow(double begin_s) {
    const Envelope gulp{begin_s, random_.uniform(0.18, 0.3), random_.uniform(0.1, 0.25), 0.3};
    close_lips(gulp);
    add("mouthPress", gulp, random_.uniform(0.3, 0.7));
    add("mouthShrugLower", gulp, random_.uniform(0.1, 0.35));
    add("mouthDimple", gulp, random_.uniform(0, 0.3));
    lean(gulp, random_.uniform(1, 4) * kRadPerDeg);
    return gulp.end_s();
  }

  /// A cup is lifted, drunk from in one to three sips, and put down.
  double drink(double begin_s) {
    const double lift_s = random_.uniform(0.6, 1.1);
    const auto sips = static_cast<double>(1 + random_.below(3));
    const double sip_s = random_.uniform(0.7, 1.2);
    const double drinks_s = sips * sip_s;
    look({begin_s, 0.15, lift_s, 0.3}, -random_.uniform(12, 25) * kRadPerDeg);
    lean({begin_s, 0.5 * lift_s, 0.1, 0.4 * lift_s}, random_.uniform(2, 6) * kRadPerDeg);
    lean({begin_s + 0.7 * lift_s, random_.uniform(0.5, 0.9), drinks_s, random_.uniform(0.5, 0.9)},
         -random_.uniform(8, 25) * kRadPerDeg);
    const double rim_s = begin_s + lift_s;
    const Envelope rim{rim_s, 0.2, drinks_s, 0.25};
    add("mouthPucker", rim, random_.uniform(0.2, 0.5));
    add("mouthFunnel", rim, random_.uniform(0.1, 0.3));
    add("mouthRollUpper", rim, random_.uniform(0, 0.15));
    add("jawOpen", rim, random_.uniform(0.06, 0.18));
    for (double s = 0; s < sips; ++s) {
      const double at_s = rim_s + 0.2 + s * sip_s;
      add("jawOpen", {at_s, 0.2, 0.05, 0.25}, random_.uniform(0.03, 0.1));
      add("mouthShrugLower", {at_s + 0.3, 0.15, 0.05, 0.2}, random_.uniform(0.1, 0.3));
    }
    return swallow(rim.end_s() + 0.1);
  }

  double lick(double begin_s) {
    const Envelope tongue{begin_s, 0.2, random_.uniform(0.1, 0.4), 0.25};
    canvas_.add_tongue(tongue, random_.uniform(0.15, 0.4));
    add("jawOpen", tongue, random_.uniform(0.1, 0.2));
    add(random_.chance(0.5) ? "mouthLeft" : "mouthRight", tongue, random_.uniform(0, 0.25));
    return tongue.end_s();
  }

  static Side other(Side side) { return side == Side::left ? Side::right : Side::left; }

  Canvas& canvas_;
  Random random_;
  double pace_hz_ = kPaceHz;
  Side favourite_ = Side::left;
};

}  // namespace

void perform_eating(Canvas& canvas, const Style& style, const Random& random) {
  Meal(canvas, style, random).eat();
}

}  // namespace mien::performer
