// Normal equations of sparse least squares.
#include <cstdint>

// The sum of column * columnᵀ over those with a weight above 0, of a matrix (rows, count) given column by column:
// where each begins (count + 1,), rows, which rise, and values of its entries. Of `sums` (rows, width), which begins
// at 0, the k-th of a row is what stands k below the diagonal.
extern "C" void normal_sums(const int32_t *begins, const int32_t *places, const double *values,
                            const double *weights, int64_t count, int64_t width, double *sums) {
    for (int64_t c = 0; c < count; ++c) {
        if (weights[c] <= 0.0)
            continue;
        for (int32_t i = begins[c]; i < begins[c + 1]; ++i) {
            double *row = sums + (width - 1) * places[i];
            for (int32_t j = i; j < begins[c + 1]; ++j)
                row[places[j]] += values[i] * values[j];
        }
    }
}
