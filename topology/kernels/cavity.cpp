// Whether a wall stands around places, or above them.
#include <cmath>
#include <cstdint>

namespace {

constexpr double TURN = 6.283185307179586;
constexpr int64_t APART = 29;  // points of a wall looked at one after the other: a few tell all directions

}  // namespace

extern "C" {

// Of places (count, 3), z upward: whether points of a wall (standing, 3) that are higher by `height` and by
// `slope` of their distance lie in so many of the sectors around them, at most 64.
void cavity_walled(const double *places, int64_t count, const double *wall, int64_t standing, double height,
                   double slope, int64_t sectors, int64_t least, uint8_t *walled) {
    for (int64_t i = 0; i < count; ++i) {
        const double *place = places + 3 * i;
        uint64_t seen = 0;
        int64_t sides = 0;
        for (int64_t first = 0; first < APART && sides < least; ++first)
            for (int64_t j = first; j < standing && sides < least; j += APART) {
                const double along = wall[3 * j] - place[0], across = wall[3 * j + 1] - place[1];
                const double rise = wall[3 * j + 2] - place[2];
                if (!(rise >= height && rise * rise >= slope * slope * (along * along + across * across))) continue;
                const double turn = std::atan2(across, along) / TURN + 0.5;
                int64_t sector = static_cast<int64_t>(turn * static_cast<double>(sectors));
                if (sector >= sectors) sector = sectors - 1;
                sides += (seen >> sector & 1) == 0;
                seen |= uint64_t{1} << sector;
            }
        walled[i] = sides >= least;
    }
}

// Of places (count, 3), z upward: whether a point of a wall (standing, 3) is higher by more than `height` and
// less than `aside` beside.
void cavity_roofed(const double *places, int64_t count, const double *wall, int64_t standing, double height,
                   double aside, uint8_t *roofed) {
    for (int64_t i = 0; i < count; ++i) {
        const double *place = places + 3 * i;
        bool found = false;
        for (int64_t j = 0; j < standing && !found; ++j) {
            const double along = wall[3 * j] - place[0], across = wall[3 * j + 1] - place[1];
            found = along * along + across * across < aside * aside && wall[3 * j + 2] - place[2] > height;
        }
        roofed[i] = found;
    }
}
}
