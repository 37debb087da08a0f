// The roles in their order: each may do what those before it may.
export const roles = ['viewer', 'therapist', 'engineer'] as const;
export type Role = (typeof roles)[number];

export const may = (role: string, least: Role): boolean => roles.findIndex((one) => one === role) >= roles.indexOf(least);
