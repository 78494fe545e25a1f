// What two pads would close on at each direction and depth of a hand, and whether the hand has room there.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace {

constexpr double INF = std::numeric_limits<double>::infinity();
enum State : int8_t { EMPTY, FEW_POINTS, WIDE, LOW, PADS, FINGERS, PALM, SLIDES, HOLDS };

// In this order in `numbers`: lengths [m], a cone [rad], and counts.
struct Numbers {
    double up[3], floor, pad_width, pad_length, opens, tip, spacing, side, least_side, under, own, brush_side,
        brush_front, cone, edge, sloped, slope, bias, rod, tight, reach, stray, few, slices;
};

struct Point {
    double x, y, z, margin;
    int64_t owner;
};

struct Seen {
    double x, y, z, normal[3];
};

struct Prism {  // and everything behind it
    double x0, x1, y0, y1, front;
};

// Whose points are most of those met; the first of several.
int64_t most(const std::vector<int64_t> &counts) {
    return std::max_element(counts.begin(), counts.end()) - counts.begin();
}

struct Met {
    bool brushed, met;
};

// Within it a part of the hand brushes by points, whatever it closes on, and before `front` at the tips.
struct Bounds {
    double wide = -INF, aside = -INF, front = -INF;

    Bounds(const Prism *prisms, int64_t count, const Numbers &n) {
        for (int64_t k = 0; k < count; ++k) {
            wide = std::max(wide, std::max(-prisms[k].x0, prisms[k].x1) + n.brush_side);
            aside = std::max(aside, std::max(-prisms[k].y0, prisms[k].y1) + n.brush_side + 1.5 * n.opens);
            front = std::max(front, prisms[k].front + n.brush_front);
        }
    }
    bool hold(double x, double y, double z, double back) const {
        return std::abs(x) < wide && std::abs(y) < aside && z - back < front;
    }
};

// Whether more than stray points are brushed by, and met by, a part of the hand whose y counts from `middle`,
// on one side where `half` is given, outwards from the pad.
Met passed(const std::vector<Point> &points, const Prism *prisms, int64_t count, double middle, double side,
           double half, double back, const Numbers &n, std::vector<Point> &some, std::vector<int64_t> &whose) {
    Met found = {false, false};
    double least = INF, most = -INF, front = -INF;
    for (int64_t k = 0; k < count; ++k) {
        least = std::min(least, prisms[k].y0 - n.brush_side), most = std::max(most, prisms[k].y1 + n.brush_side);
        front = std::max(front, prisms[k].front + n.brush_front);
    }
    some.clear();
    for (const Point &p : points) {
        const double y = side * (p.y - middle) - half, z = p.z - back;
        if (y > least && y < most && z < front) some.push_back({p.x, y, z, p.margin, p.owner});
    }
    for (int64_t k = 0; k < count; ++k) {
        const Prism &prism = prisms[k];
        double brushed = 0, met = 0;
        for (const Point &p : some) {
            if (p.z >= prism.front + n.brush_front) continue;
            const double aside =
                std::max(std::max(prism.x0 - p.x, p.x - prism.x1), std::max(prism.y0 - p.y, p.y - prism.y1));
            if (aside >= n.brush_side) continue;
            ++brushed;
            if (aside < p.margin && p.z < prism.front + p.margin) ++met, ++whose[p.owner];
        }
        found.brushed |= brushed > n.stray;
        found.met |= met > n.stray;
    }
    return found;
}

// Angle between the pad and the outline along x, a line through the outermost points of slices [rad].
double outline(const std::vector<Seen> &held, const std::vector<int64_t> &window, double side, const Numbers &n) {
    double low = INF, high = -INF;
    for (const int64_t i : window) low = std::min(low, held[i].x), high = std::max(high, held[i].x);
    if (high - low < n.rod) return 0.0;
    const int64_t slices = static_cast<int64_t>(n.slices);
    std::vector<int64_t> outermost(slices, -1);
    for (const int64_t i : window) {
        const double share = (held[i].x - low) / std::max(high - low, 1e-12) * n.slices;
        int64_t &best = outermost[std::min(static_cast<int64_t>(share), slices - 1)];
        if (best < 0 || side * held[i].y > side * held[best].y) best = i;
    }
    double count = 0, x = 0, y = 0, product = 0, square = 0;
    for (const int64_t i : outermost)
        if (i >= 0) ++count, x += held[i].x, y += held[i].y;
    if (count < 3) return 0.0;
    for (const int64_t i : outermost) {
        if (i < 0) continue;
        product += (held[i].x - x / count) * (held[i].y - y / count);
        square += (held[i].x - x / count) * (held[i].x - x / count);
    }
    return std::abs(std::atan(product / std::max(square, 1e-12)));
}

// How well a pad holds on the side at an edge, to 1; nothing at the friction cone and beyond.
double side_holds(const std::vector<Seen> &held, const std::vector<int64_t> &window, double side, double edge,
                  double widest, const Numbers &n, std::vector<double> &squares) {
    double x = 0, seen = 0, mean[3] = {0, 0, 0};
    squares.clear();
    for (const int64_t i : window) {
        const Seen &p = held[i];
        if (std::abs(p.y - edge) >= n.edge) continue;
        x += p.x;
        squares.push_back(side * p.normal[1]);
        if (squares.back() <= 0.5) continue;
        ++seen;
        for (int k = 0; k < 3; ++k) mean[k] += p.normal[k];
    }
    const int64_t count = static_cast<int64_t>(squares.size());
    const bool known = seen >= std::max(2.0, 0.3 * static_cast<double>(count));
    if (!(std::abs(x / static_cast<double>(count)) <= 0.3 * n.pad_width)) return 0.0;
    double angle = 0.25 * n.cone;
    if (known) {
        const double length = std::sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]);
        const double cosine = std::min(std::max(side * mean[1] / std::max(length, 1e-12), -1.0), 1.0);
        angle = std::max(0.0, std::acos(cosine) - n.bias);
    } else {  // too flat a slope to press on where it is seen: pads would slide off its wedge
        std::sort(squares.begin(), squares.end());
        if ((squares[(count - 1) / 2] + squares[count / 2]) / 2.0 > n.sloped) return 0.0;
        angle += outline(held, window, side, n);
    }
    const double widening = widest - side * edge;
    if (widening > n.spacing) angle = std::max(angle, std::atan2(widening, n.slope));
    return 1.0 - angle / n.cone;
}

}  // namespace

extern "C" {

// Of F directions (F, 3, 3) about a point and D depths the states (F, D), what leaves no room (F, D), and
// (F, D, 5) the depth of the tips, where the pads meet the object, how free the way is, and how well they
// hold. The object's N points and normals, M others with their owners below `owners`, prisms as five numbers.
void pinch_windows(const double *points, const double *normals, int64_t own, const double *others,
                   const int64_t *owner, int64_t foreign, int64_t owners, const double *origin,
                   const double *turns, int64_t directions, const double *depths, int64_t tried,
                   const Prism *fingers, int64_t finger, const Prism *palm, int64_t body, const double *given,
                   int8_t *states, int64_t *barring, double *values) {
    const Numbers &n = *reinterpret_cast<const Numbers *>(given);
    const Bounds beside(fingers, finger, n), behind(palm, body, n);
    std::vector<double> offsets[3];
    std::vector<int64_t> whoses;
    for (int64_t i = 0; i < own + foreign; ++i) {
        const double *p = i < own ? points + 3 * i : others + 3 * (i - own);
        const double x = p[0] - origin[0], y = p[1] - origin[1], z = p[2] - origin[2];
        if (i >= own && x * x + y * y + z * z >= n.reach * n.reach) continue;
        offsets[0].push_back(x), offsets[1].push_back(y), offsets[2].push_back(z);
        whoses.push_back(i < own ? owners : owner[i - own]);
    }
    const int64_t count = static_cast<int64_t>(whoses.size());
    std::vector<double> x(count), y(count), z(count);
    std::vector<Seen> held;
    std::vector<std::pair<double, int64_t>> order;  // along the closing axis
    std::vector<Point> closing, outside, above, some;  // what pads, fingers and palm can meet
    std::vector<double> heights, squares;
    std::vector<int64_t> window, whose(owners + 1);
    const double height = origin[0] * n.up[0] + origin[1] * n.up[1] + origin[2] * n.up[2] - n.floor;
    for (int64_t f = 0; f < directions; ++f) {
        const double *r = turns + 9 * f;
        auto along = [r](const double *p, double *place) {
            for (int k = 0; k < 3; ++k) place[k] = p[0] * r[k] + p[1] * r[3 + k] + p[2] * r[6 + k];
        };
        double upwards[3];
        along(n.up, upwards);
        for (int64_t i = 0; i < count; ++i) {
            const double a = offsets[0][i], b = offsets[1][i], c = offsets[2][i];
            x[i] = a * r[0] + b * r[3] + c * r[6];
            y[i] = a * r[1] + b * r[4] + c * r[7];
            z[i] = a * r[2] + b * r[5] + c * r[8];
        }
        held.clear(), order.clear(), heights.clear(), closing.clear(), outside.clear(), above.clear();
        for (int64_t i = 0; i < own; ++i) {
            if (std::abs(x[i]) > n.pad_width / 2.0 || std::abs(y[i]) > n.opens) continue;
            order.push_back({y[i], i});
            if (std::abs(y[i]) <= n.opens / 2.0) heights.push_back(z[i]);
        }
        if (heights.size() < 4) continue;
        std::sort(order.begin(), order.end());
        for (const auto &[side, i] : order) {
            held.push_back({x[i], y[i], z[i], {0, 0, 0}});
            along(normals + 3 * i, held.back().normal);
        }
        const size_t rank = std::min(static_cast<size_t>(n.stray), heights.size() - 1);
        std::nth_element(heights.begin(), heights.begin() + rank, heights.end());
        const double top = heights[rank], deepest_tip = top + depths[tried - 1], farthest = deepest_tip - n.tip;
        const double behind_all = std::max(deepest_tip, farthest + std::max(beside.front, behind.front));
        for (int64_t i = 0; i < count; ++i) {
            if (z[i] >= behind_all) continue;  // most of what things lie on
            const Point point = {x[i], y[i], z[i], i < own ? n.own : n.under, whoses[i]};
            if (beside.hold(x[i], y[i], z[i], farthest)) outside.push_back(point);
            if (behind.hold(x[i], y[i], z[i], farthest)) above.push_back(point);
            if (i >= own && z[i] < deepest_tip && std::abs(x[i]) < n.pad_width / 2.0) closing.push_back(point);
        }
        for (int64_t d = 0; d < tried; ++d) {
            int8_t &state = states[f * tried + d];
            double *value = values + 5 * (f * tried + d);
            const double tip = top + depths[d], back = tip - n.tip;
            state = FEW_POINTS;
            window.clear();
            for (size_t i = 0; i < held.size(); ++i)
                if (held[i].z <= tip && held[i].z >= tip - n.pad_length) window.push_back(i);
            if (window.size() < 3) continue;
            size_t nearest = 0;
            for (size_t k = 1; k < window.size(); ++k)
                if (std::abs(held[window[k]].y) < std::abs(held[window[nearest]].y)) nearest = k;
            size_t first = nearest, last = nearest;  // up to a gap that a finger could enter
            const double gap = 2.5 * n.spacing;
            while (first > 0 && held[window[first]].y - held[window[first - 1]].y <= gap) --first;
            while (last + 1 < window.size() && held[window[last + 1]].y - held[window[last]].y <= gap) ++last;
            const size_t skip = (last - first + 1) / static_cast<size_t>(n.few);
            const double low = held[window[first + skip]].y, high = held[window[last - skip]].y;
            window.erase(std::remove_if(window.begin(), window.end(), [&](int64_t i) {
                return held[i].y < low || held[i].y > high;
            }), window.end());
            if (window.size() < 3) continue;
            const double opening = std::min(n.opens, high - low + 2.0 * n.side), half = opening / 2.0;
            const double middle = (low + high) / 2.0;
            value[0] = tip, value[1] = low, value[2] = high;
            state = WIDE;
            if (high - low + 2.0 * n.least_side > n.opens) continue;
            double lowest = INF;
            auto corner = [&](const Prism &p, double y0, double y1) {
                lowest = std::min(lowest, std::min(upwards[0] * p.x0, upwards[0] * p.x1) +
                                              std::min(upwards[1] * y0, upwards[1] * y1) + upwards[2] * p.front);
            };
            for (int64_t k = 0; k < finger; ++k) {
                corner(fingers[k], half + fingers[k].y0, half + fingers[k].y1);
                corner(fingers[k], -half - fingers[k].y1, -half - fingers[k].y0);
            }
            for (int64_t k = 0; k < body; ++k) corner(palm[k], palm[k].y0, palm[k].y1);
            state = LOW;
            if (!(height + (lowest + upwards[1] * middle + upwards[2] * back) >= n.under)) continue;
            std::fill(whose.begin(), whose.end(), 0);
            double closed = 0;
            for (const Point &p : closing)
                if (std::abs(p.y - middle) < half && p.z < tip) ++closed, ++whose[p.owner];
            bool brushed = false;
            state = PADS;
            bool met = closed > n.stray;
            for (int part = 0; part < 2 && !met; ++part) {
                std::fill(whose.begin(), whose.end(), 0);
                state = part == 0 ? FINGERS : PALM;
                for (const double side : {1.0, -1.0}) {
                    if (part == 1 && side < 0) break;
                    const Met found = part == 0 ? passed(outside, fingers, finger, middle, side, half, back, n, some, whose)
                                                : passed(above, palm, body, middle, side, 0.0, back, n, some, whose);
                    brushed |= found.brushed, met |= found.met;
                }
            }
            if (met) {
                barring[f * tried + d] = most(whose);
                continue;
            }
            double deepest = -INF, widest[2] = {-INF, -INF}, worst = 1.0;
            for (const int64_t i : window) deepest = std::max(deepest, held[i].z);
            for (const Seen &p : held) {
                if (p.z <= deepest || p.z >= deepest + n.slope) continue;
                if (std::abs(p.y - middle) >= (high - low) / 2.0 + n.side) continue;
                widest[0] = std::max(widest[0], -p.y), widest[1] = std::max(widest[1], p.y);
            }
            worst = std::min(worst, side_holds(held, window, -1.0, low, widest[0], n, squares));
            worst = std::min(worst, side_holds(held, window, 1.0, high, widest[1], n, squares));
            state = worst > 0.0 ? HOLDS : SLIDES;
            value[3] = brushed ? n.tight : 1.0, value[4] = worst;
        }
    }
}
}
