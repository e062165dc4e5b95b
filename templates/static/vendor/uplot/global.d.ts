// The script of uPlot is loaded before the modules of a page, and defines this name.
import type uPlot from "uplot";

declare global {
  interface Window {
    uPlot: typeof uPlot;
  }
}
