export const browserProgram: string | undefined;
export function drawLess(): void;
