// Which surfaces of a picture pixels continue: rays to the nearest insides, and the planes fitted there.
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace {

struct Picture {  // pixels in rows one after the other, with a margin that neither rays nor patches leave
    const double *inverse;
    const int64_t *label, *surface;
    int64_t width, patch;
    double narrow;
};

struct Plane {
    double level, down, right;
};

// The plane of inverse depth around a pixel, of those of its patch that are of its mask's surface.
Plane plane_around(const Picture &picture, int64_t at) {
    double count = 0, row = 0, column = 0, rows = 0, columns = 0, both = 0, level = 0, by_row = 0, by_column = 0;
    const int64_t half = picture.patch / 2;
    for (int64_t d = -half; d <= half; ++d)
        for (int64_t r = -half; r <= half; ++r) {
            const int64_t place = at + d * picture.width + r;
            if (picture.surface[place] != picture.label[at]) continue;
            const double down = static_cast<double>(d), right = static_cast<double>(r), near = picture.inverse[place];
            count += 1, row += down, column += right;
            rows += down * down, columns += right * right, both += down * right;
            level += near, by_row += near * down, by_column += near * right;
        }
    row /= count, column /= count, level /= count;
    rows = rows / count - row * row + picture.narrow, columns = columns / count - column * column + picture.narrow;
    both = both / count - row * column;
    by_row = by_row / count - level * row, by_column = by_column / count - level * column;
    const double area = rows * columns - both * both;
    const double down = (by_row * columns - by_column * both) / area, right = (by_column * rows - by_row * both) / area;
    return {level - down * row - right * column, down, right};
}

}  // namespace

extern "C" {

// Planes around pixels: inverse depth, its slope down and that to the right, (3, count).
void continued_planes(const double *inverse, const int64_t *label, const int64_t *surface, int64_t width,
                      int64_t patch, double narrow, const int64_t *at, int64_t count, double *planes) {
    const Picture picture{inverse, label, surface, width, patch, narrow};
    for (int64_t i = 0; i < count; ++i) {
        const Plane plane = plane_around(picture, at[i]);
        planes[i] = plane.level, planes[count + i] = plane.down, planes[2 * count + i] = plane.right;
    }
}

// Of pixels (count,) the steps to the nearest inside, whose surface they continue, and whether they lie before
// all. Rays go `ways` (n, 2) rows and columns a step, at most `far` steps; of their own mask or of others.
void continued_surfaces(const double *inverse, const int64_t *label, const int64_t *surface, int64_t width,
                        int64_t patch, double narrow, const int64_t *ways, int64_t n, int64_t far, double off,
                        double least, int64_t none, int64_t nobody, int64_t own, const int64_t *at, int64_t count,
                        int64_t *nearest, int64_t *owner, uint8_t *ahead) {
    const Picture picture{inverse, label, surface, width, patch, narrow};
    for (int64_t i = 0; i < count; ++i) {
        const int64_t mine = label[at[i]];
        const double depth = 1.0 / inverse[at[i]], large = std::max(1.0, depth), most = off * (large * large);
        nearest[i] = far + 1, owner[i] = nobody, ahead[i] = 1;
        for (int64_t w = 0; w < n && owner[i] == nobody; ++w) {
            const int64_t step = ways[2 * w] * width + ways[2 * w + 1];
            int64_t end = at[i], steps = 0;
            bool hit = false;
            while (!hit && steps < far) {
                end += step, ++steps;
                hit = own ? surface[end] == mine : surface[end] != none && surface[end] != mine;
            }
            if (!hit) continue;
            nearest[i] = std::min(nearest[i], steps);
            const Plane plane = plane_around(picture, end);
            const double slope = static_cast<double>(ways[2 * w]) * plane.down + static_cast<double>(ways[2 * w + 1]) * plane.right;
            const double there = plane.level - static_cast<double>(steps) * slope;
            const double behind = 1.0 / std::max(there, least) - depth;
            if (!(behind > most)) ahead[i] = 0;
            if (std::fabs(behind) <= most) owner[i] = label[end];
        }
    }
}
}
