// How the line of each run looks in all charts: by its position.

export const COLOURS = ["--chart-1", "--chart-2", "--chart-3", "--chart-4", "--chart-5"];
export const DASHES = [[], [], [6, 3], [2, 3], [10, 3, 2, 3]];
