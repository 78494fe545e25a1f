// Pictures of triangles: what lies nearest on the ray through the middle of each pixel.
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace {

// A triangle as a pinhole camera sees it. On the ray through pixel (u, v) the weight of corner i is
// w[i] = across[i] * u + down[i] * v + rest[i], up to a factor: the triangle is met where none is below 0, and
// their sum over `volume` is one over the depth (Olano and Greer, "Triangle scan conversion using 2D
// homogeneous coordinates", 1997). Nothing has to be cut at the plane of the eye.
struct Seen {
    double across[3], down[3], rest[3], volume;
    int64_t left, right, top, bottom; // a box around it in the picture
};

Seen seen_by(const double *p, const double *lens, int64_t width, int64_t height, double nearest) {
    const double fx = lens[0], fy = lens[1], cx = lens[2], cy = lens[3];
    Seen s;
    for (int i = 0; i < 3; ++i) {
        const double *a = p + 3 * ((i + 1) % 3), *b = p + 3 * ((i + 2) % 3);
        s.across[i] = (a[1] * b[2] - a[2] * b[1]) / fx;
        s.down[i] = (a[2] * b[0] - a[0] * b[2]) / fy;
        s.rest[i] = (a[0] * b[1] - a[1] * b[0]) - s.across[i] * cx - s.down[i] * cy;
    }
    s.volume = p[0] * (p[4] * p[8] - p[5] * p[7]) + p[1] * (p[5] * p[6] - p[3] * p[8]) + p[2] * (p[3] * p[7] - p[4] * p[6]);
    double low[2] = {0.0, 0.0}, high[2] = {static_cast<double>(width - 1), static_cast<double>(height - 1)};
    const double first = std::min({p[2], p[5], p[8]}), last = std::max({p[2], p[5], p[8]});
    if (first >= nearest) {
        const double u[3] = {fx * p[0] / p[2] + cx, fx * p[3] / p[5] + cx, fx * p[6] / p[8] + cx};
        const double v[3] = {fy * p[1] / p[2] + cy, fy * p[4] / p[5] + cy, fy * p[7] / p[8] + cy};
        low[0] = std::max(low[0], std::floor(std::min({u[0], u[1], u[2]})));
        low[1] = std::max(low[1], std::floor(std::min({v[0], v[1], v[2]})));
        high[0] = std::min(high[0], std::ceil(std::max({u[0], u[1], u[2]})));
        high[1] = std::min(high[1], std::ceil(std::max({v[0], v[1], v[2]})));
    }
    const bool none = last < nearest || s.volume == 0.0 || !(low[0] <= high[0] && low[1] <= high[1]);
    s.left = none ? 0 : static_cast<int64_t>(low[0]);
    s.right = none ? -1 : static_cast<int64_t>(high[0]);
    s.top = none ? 0 : static_cast<int64_t>(low[1]);
    s.bottom = none ? -1 : static_cast<int64_t>(high[1]);
    return s;
}

} // namespace

// Draw triangles, corners (count, 3, 3) in the camera's frame, onto `inverse` (height, width), one over the depth,
// which the caller filled with one over the farthest depth, and `owner` (height, width), their numbers, filled with
// -1. `lens` is fx, fy, cx, cy. `colours` (height, width, 3) are those of the corners (count, 3, 3), 0..255, between them.
extern "C" void triangles_drawn(const double *corners, int64_t count, const double *lens, int64_t width, int64_t height,
                                double nearest, double *inverse, int64_t *owner, const double *paints, uint8_t *colours) {
    const double most = 1.0 / nearest;
    for (int64_t t = 0; t < count; ++t) {
        const Seen s = seen_by(corners + 9 * t, lens, width, height, nearest);
        const double sign = s.volume > 0.0 ? 1.0 : -1.0;
        const double step = (s.across[0] + s.across[1] + s.across[2]) / s.volume;
        for (int64_t v = s.top; v <= s.bottom; ++v) {
            // neighbours share an edge's numbers but for their sign: no pixel falls between them
            double low = static_cast<double>(s.left), high = static_cast<double>(s.right), start = 0.0;
            for (int i = 0; i < 3; ++i) {
                const double slope = sign * s.across[i], at = sign * (s.down[i] * static_cast<double>(v) + s.rest[i]);
                start += s.down[i] * static_cast<double>(v) + s.rest[i];
                if (slope > 0.0) low = std::max(low, std::ceil(-at / slope));
                else if (slope < 0.0) high = std::min(high, std::floor(-at / slope));
                else if (at < 0.0) high = -1.0;
            }
            if (!(low <= high)) continue;
            start /= s.volume;
            for (int64_t u = static_cast<int64_t>(low), last = static_cast<int64_t>(high); u <= last; ++u) {
                const double near = start + step * static_cast<double>(u);
                const int64_t k = v * width + u;
                if (near > inverse[k] && near <= most) {
                    inverse[k] = near;
                    owner[k] = t;
                }
            }
        }
    }
    int64_t before = -1;
    Seen s{};
    for (int64_t k = 0; k < width * height; ++k) {
        const int64_t t = owner[k];
        if (t < 0) continue;
        if (t != before) s = seen_by(corners + 9 * t, lens, width, height, nearest);
        before = t;
        double sum = 0.0, mixed[3] = {0.0, 0.0, 0.0};
        for (int i = 0; i < 3; ++i) {
            const double weight = s.across[i] * static_cast<double>(k % width) + s.down[i] * static_cast<double>(k / width) + s.rest[i];
            sum += weight;
            for (int c = 0; c < 3; ++c) mixed[c] += weight * paints[9 * t + 3 * i + c];
        }
        for (int c = 0; c < 3; ++c) colours[3 * k + c] = static_cast<uint8_t>(std::min(std::max(mixed[c] / sum, 0.0), 255.0));
    }
}
