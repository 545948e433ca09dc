/** The page's signs, drawn here: strokes on a 24 by 24 grid. */
import { icon } from "./dom";

export const playIcon = () => icon("M8 5.5v13l10.5-6.5z", true);
export const pauseIcon = () => icon("M7 5h3.6v14H7zM13.4 5H17v14h-3.6z", true);
export const recordIcon = () => icon("M12 6a6 6 0 1 0 .01 0z", true);
export const stopIcon = () => icon("M7 7h10v10H7z", true);
export const calibrateIcon = () => icon("M12 3v3M12 18v3M3 12h3M18 12h3M12 7.2a4.8 4.8 0 1 0 .01 0zM12 11.4a.6.6 0 1 0 .01 0z");
export const recentreIcon = () => icon("M4 9V5h4M20 9V5h-4M4 15v4h4M20 15v4h-4M12 9.6a2.4 2.4 0 1 0 .01 0z");
export const viewIcon = () => icon("M2.8 12S6.2 6 12 6s9.2 6 9.2 6-3.4 6-9.2 6-9.2-6-9.2-6zM12 9.4a2.6 2.6 0 1 0 .01 0z");
export const faceIcon = () => icon("M12 3.2a7 7.6 0 0 1 7 7.6c0 5-3.4 10-7 10s-7-5-7-10a7 7.6 0 0 1 7-7.6zM9 10.2v.6M15 10.2v.6M9 15c1.7 1.6 4.3 1.6 6 0");
export const moonIcon = () => icon("M19.5 14.2A8 8 0 0 1 9.8 4.5a8 8 0 1 0 9.7 9.7z");
export const sunIcon = () => icon("M12 8a4 4 0 1 0 .01 0zM12 2.5v2M12 19.5v2M2.5 12h2M19.5 12h2M5.3 5.3l1.4 1.4M17.3 17.3l1.4 1.4M5.3 18.7l1.4-1.4M17.3 6.7l1.4-1.4");
export const autoIcon = () => icon("M12 4a8 8 0 1 0 .01 0zM12 4v16M14.5 5v14M17 7v10");
export const helpIcon = () => icon("M9.2 9.2a2.9 2.9 0 1 1 4 2.7c-.8.4-1.2 1-1.2 1.9M12 16.8v.2M12 3.2a8.8 8.8 0 1 0 .01 0z");
export const weightsIcon = () => icon("M4 7h10M4 12h16M4 17h7");
export const sensorsIcon = () => icon("M12 11a1.4 1.4 0 1 0 .01 0zM8.2 8.2a5.6 5.6 0 0 0 0 8M15.8 8.2a5.6 5.6 0 0 1 0 8M5.4 5.4a9.6 9.6 0 0 0 0 13.4M18.6 5.4a9.6 9.6 0 0 1 0 13.4");
export const takesIcon = () => icon("M4 5.5h16v13H4zM4 9h16M8 5.5 6.6 9M13 5.5 11.6 9M18 5.5 16.6 9");
export const outputIcon = () => icon("M4 12h14M12.5 6.5 18 12l-5.5 5.5");
